"""Words of certificates: key -> English, German."""

TEXTS: dict[str, tuple[str, str]] = {
    "c_title": ("Calibration certificate", "Kalibrierzertifikat"),
    "c_verdict": ("Verdict: {word}", "Urteil: {word}"),
    "c_simulated": (
        "Simulated: sensors and encoders were computed, no machine was measured.",
        "Simuliert: Sensoren und Geber wurden berechnet, keine Maschine gemessen.",
    ),
    "c_object": ("Object and run", "Gegenstand und Lauf"),
    "c_issued_by": ("Issued by", "Ausgestellt von"),
    "c_operator": ("Operator", "Bearbeiter"),
    "c_issued": ("Date of issue", "Ausgestellt am"),
    "c_recorded": ("Date of the recording", "Aufgezeichnet am"),
    "c_by_file": ("{date} (by its file)", "{date} (nach ihrer Datei)"),
    "c_machine": ("Machine", "Maschine"),
    "c_of_setup": ("{case}, setup {setup}", "{case}, Aufbau {setup}"),
    "c_serial": ("Serial numbers", "Seriennummern"),
    "c_conditions": ("Conditions", "Bedingungen"),
    "c_program": ("Program", "Programm"),
    "c_method": ("Method", "Verfahren"),
    "c_weights_equal": ("equal", "gleich"),
    "c_weights_per_channel": ("per_channel", "je Kanal"),
    "c_weights_per_unit": ("per_unit", "je Einheit"),
    "c_weights_stated": ("stated", "nach dem angegebenen Rauschen"),
    "c_of_standstills": ("averaged standstills", "gemittelten Stillständen"),
    "c_of_samples": ("samples of a motion", "Abtastungen einer Bewegung"),
    "c_known": ("{name} = {value:g} known", "{name} = {value:g} bekannt"),
    "c_prior": ("prior of {name}", "Vorwissen über {name}"),
    "c_by": (
        "Parameters of the inverse model {model} (Friedrich & Ihlenfeldt, Sensors 21 (2021) 3537) by least squares, "
        "weights {weights}, from {samples} {of}; rank {rank}, condition {condition:.3g}, s0 {s0:.3g}{more}.",
        "Parameter des inversen Modells {model} (Friedrich & Ihlenfeldt, Sensors 21 (2021) 3537) nach kleinsten "
        "Quadraten, Gewichte {weights}, aus {samples} {of}; Rang {rank}, Kondition {condition:.3g}, s0 {s0:.3g}{more}.",
    ),
    "c_parameters": (
        "Parameters with expanded uncertainty U (k = {k:g})",
        "Parameter mit erweiterter Unsicherheit U (k = {k:g})",
    ),
    "c_verdicts": ("Verdicts", "Urteile"),
    "c_not_judged": ("Not judged: {reason}.", "Nicht beurteilt: {reason}."),
    "c_counts": ("U counts: {what}.", "U enthält: {what}."),
    "c_counts_not": (
        "U does NOT count tolerances of: {what} (the case states none).",
        "U enthält KEINE Toleranzen von: {what} (die Maschine nennt keine).",
    ),
    "c_warnings": ("Warnings", "Warnungen"),
    "c_chain": ("Chain of fingerprints", "Kette der Fingerabdrücke"),
    "c_case": ("Case", "Maschine"),
    "c_plan": ("Plan", "Plan"),
    "c_recording": ("Recording", "Aufzeichnung"),
    "c_result": ("Result", "Ergebnis"),
    "c_versions": ("Computed with", "Berechnet mit"),
    "c_verify": (
        "hexcite certificate --verify FILE shows whether this file is as it was issued. It bears no signature.",
        "hexcite certificate --verify DATEI zeigt, ob diese Datei ist, wie sie ausgestellt wurde. Sie trägt keine "
        "Unterschrift.",
    ),
    "c_page": ("page {k} of {count}", "Seite {k} von {count}"),
}

WEIGHTS = frozenset(key.removeprefix("c_weights_") for key in TEXTS if key.startswith("c_weights_"))
"""Weights of the fit that have words."""
