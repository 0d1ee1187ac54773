"""A recorded run made ready for an estimate: rates, filters, delay, sections, standstills."""
