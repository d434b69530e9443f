"""Corruptions of finished maps: each by name, strength and seed, and the noise levels composed of them."""

from scenarios.corruption.catalogue import CORRUPTIONS, check_corruptions, corrupt
from scenarios.corruption.noise_levels import NOISE_LEVELS, add_noise, noise_strength
from scenarios.corruption.point_motions import CorruptedMap

__all__ = ["CORRUPTIONS", "NOISE_LEVELS", "CorruptedMap", "add_noise", "check_corruptions", "corrupt", "noise_strength"]
