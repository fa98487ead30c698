"""Controllers as source code for machines that have no Python: microcontrollers and real-time loops."""

from prp_gym.exporting.c_header import CHeader, c_header, default_prefix

__all__ = ["CHeader", "c_header", "default_prefix"]
