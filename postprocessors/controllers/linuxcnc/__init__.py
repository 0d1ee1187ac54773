"""Runs a program on a real LinuxCNC, headless and faster than real time, and logs every servo cycle."""
