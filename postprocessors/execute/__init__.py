"""Runs programs: the built-in virtual controller, or a real LinuxCNC."""
