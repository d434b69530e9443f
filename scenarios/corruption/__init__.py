"""Damage to a finished map: single kinds with a strength and a seed, and the noise levels made of them."""

from scenarios.corruption.kinds import KINDS, check_damages, corrupt
from scenarios.corruption.levels import NOISE_LEVELS, damage, noise_strength
from scenarios.corruption.motions import Damaged

__all__ = ["KINDS", "NOISE_LEVELS", "Damaged", "check_damages", "corrupt", "damage", "noise_strength"]
