"""The calibrated measurement model as code and data for controllers: C99, Structured Text, LinuxCNC HAL, ISG, JSON."""
