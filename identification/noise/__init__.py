"""The noise of a run: as a case states it, as residuals tell it, and what it does to an estimate."""
