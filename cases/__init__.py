"""What stands on the shop floor, as data: machines, sensors, limits and experiments."""
