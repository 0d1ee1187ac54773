"""What a certificate states of a machine beside its results: `[certificate]` of a case."""

from collections.abc import Mapping

from cases.tables import Part, Text


class CertificateOf(Part):
    """What certificates of this machine say; all of it may be left out."""

    laboratory: Text | None = None
    """Who issues it: name and place."""
    operator: Text | None = None
    """Who recorded and evaluated the run."""
    serial_numbers: Mapping[Text, Text] | None = None
    """Serial numbers by part: machine, sensors, amplifier."""
    conditions: Text | None = None
    """Conditions of the run: temperature, warm-up, tool, hoses."""
