"""What tests of plans share with those of the commands: a cache of their own, and a plan made once for all workers."""

from tests.hexcite.conftest import cache, chain, hexapod_file, once, planned, saved_plan, shared

__all__ = ["cache", "chain", "hexapod_file", "once", "planned", "saved_plan", "shared"]
