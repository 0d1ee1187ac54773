"""A recorded run made ready for an estimate: damage, rates, filters, delay, sections, standstills, and its noise."""
