"""Programs executed: by LinuxCNC, or by a virtual controller that is written from the guarantees."""
