"""Corruptions of finished maps: each by name, strength and seed, and the noise levels composed of them."""

from scenarios.corruption.catalogue import CORRUPTIONS, check_corruptions, corrupt
from scenarios.corruption.noise_levels import NOISE_LEVELS, NoiseLevel, add_noise, find_noise
from scenarios.corruption.point_motions import CorruptedMap

__all__ = [
    "CORRUPTIONS",
    "NOISE_LEVELS",
    "CorruptedMap",
    "NoiseLevel",
    "add_noise",
    "check_corruptions",
    "corrupt",
    "find_noise",
]
