"""German for sentences that commands make of codes and values: causes, remedies and findings, by code."""

CAUSES = {
    "cause": "{words}: Dann sind die Residuen {smaller} ({newtons} N, wo Rauschen {noise} N macht); {remedies}",
    "small": "klein",
    "times_smaller": "{times}-mal kleiner",
    "write": "zu schreiben: {keys}",
    "too_loose": "zu ungenau bekannt, um in die Maschine geschrieben zu werden ({why}): an der Maschine messen und das "
    "schreiben",
    "would_be_off": "{name} läge um {off} {unit} daneben, wo {reported} {unit} angegeben würde",
    "explained": "{problem} ({tried})",
    "not_one": "nichts davon erklärt {left}: {tried}",
    "not_two": "nichts davon, auch nicht zwei zusammen, erklärt {left}: {tried}",
    "least_left": "{nothing}; am wenigsten bleibt, {newtons} N, mit: {words}",
    "residuals_of": "Residuen von {newtons} N, wo Rauschen {noise} N macht",
    "the_run": "den Lauf",
    "family_clock": "Uhren",
    "family_orientation": "Arten, Orientierungen zu schreiben",
    "family_units": "Einheiten",
    "family_channels": "vertauschte, verschobene und umgekehrte Kraftkanäle",
    "family_gains": "Maßstäbe einzelner Kanäle",
    "family_drives": "vertauschte und verschobene {drives}",
    "family_axes": "Kräfte und Momente in den Achsen der Basis",
    "family_point": "Momente um einen anderen Punkt",
    "family_compensated": "kompensierte Kräfte",
    "family_sensor": "ein verdrehter Sensor",
    "family_signs": "Vorzeichen der {drives}",
    "family_offsets": "Nullpunkte der {drives}",
    "family_gravity": "Schwerkraft",
    "family_machine": "Ringe, Gelenke und Grundstellung des Hexapods",
    "family_bars": "Ringe und Enden der Stäbe",
    "family_leaps": "ein springender Nullpunkt",
}
"""The cause of a run's residuals, or what was tried."""

CHANNELS = {
    "exchanged": "{what}: {pairs} vertauscht",
    "pair": "{one} und {other}",
    "shifted": "{what}: um {places} verschoben",
    "reordered": "{what} in anderer Reihenfolge: {cycle}",
    "in_place_of": "{one} steht an der Stelle von {other}",
    "force_channels": "Kraftkanäle",
    "forces_and_moments": "Kräfte und Momente",
    "struts": "Streben",
    "joints": "Gelenke",
    "positions": "Positionen",
    "quaternion": "Teile des Quaternions",
    "channel_signs": "Vorzeichen der Kraftkanäle {numbers} umgekehrt",
    "moments_in": "Momente in {unit}",
    "gain_small": "{name} ist {size} % kleiner, als die anderen Kanäle sagen",
    "gain_large": "{name} ist {size} % größer, als die anderen Kanäle sagen",
    "about_axis": "{angle} Grad um seine {axis}-Achse",
    "about": "{angle} Grad um ({along})",
    "sensor_turned": "Der Sensor ist verdreht, um {about}",
    "turn_it": "Kräfte und Momente im Rekorder drehen, um {about}",
    "moments_about": "Momente um einen Punkt ({place}) mm vom Ursprung des Sensors, in dessen Achsen",
    "record_about_origin": "Momente um den Ursprung des Sensors aufzeichnen",
    "compensated": "Die Kräfte sind kompensiert: Es fehlt das Gewicht dessen, was der Sensor trägt",
    "compensated_in_part": "Die Kräfte sind kompensiert: Es fehlen {share} % des Gewichts dessen, was der Sensor trägt",
    "record_raw": "roh aufzeichnen, jede Kompensation von Werkzeug oder Nutzlast ausgeschaltet",
    "in_base": "Kräfte und Momente stehen in den Achsen der Basis, nicht des Sensors",
    "record_in_sensor": "roh aufzeichnen, in den Achsen des Sensors selbst",
    "offsets_leap": "Nullpunkte springen: {parts},",
    "by": "{of} um {size} {unit}",
    "load_changes": "Die Last ändert sich um {size} kg",
    "at_about": "{what} bei etwa {line}{time}",
    "cut_there": "den Lauf dort teilen und die Teile einzeln auswerten, der längere ist {longer}",
    "before_line": "vor {line}",
    "from_line": "ab {line}",
}
"""Mistakes in recorded forces."""

MOTION = {
    "struts_in": "{role} in {unit}",
    "strut_signs": "Vorzeichen der Streben {which} umgekehrt",
    "alphabetic": "{words} (sie wurden in der Reihenfolge des Alphabets aufgezeichnet)",
    "joints_turning": "Drehgelenke",
    "joints_sliding": "Schubgelenke",
    "joints_in": "{every} in {unit}",
    "joints_turn_back": "Die Gelenke {names} drehen andersherum",
    "joints_move_back": "Die Gelenke {names} laufen andersherum",
    "joint_turns_back": "Gelenk {names} dreht andersherum",
    "joint_moves_back": "Gelenk {names} läuft andersherum",
    "joint_zero": "Gelenk {joint} steht bei {angle} Grad, wo es 0 anzeigt",
    "joints_leap": "Anzeigen der Gelenke {names} springen um 360 Grad",
    "joint_leaps": "Die Anzeige von Gelenk {names} springt um 360 Grad",
    "forces_late": "Kräfte sind {size} ms später gestempelt als die Bewegung",
    "forces_early": "Kräfte sind {size} ms früher gestempelt als die Bewegung",
    "stamps_in": "Zeitstempel in {unit}",
    "samples_apart": "Der Abstand der Abtastungen ist {apart} ms, nicht {stated} ms",
    "written_as": "Orientierungen sind als '{name}' geschrieben{users}",
    "angles_in": "Winkel der Pose in {unit}",
    "positions_in": "Positionen in {unit}",
    "sign_turned": "Vorzeichen von {name} umgekehrt",
}
"""Mistakes in the recorded motion and its clock."""

MACHINE = {
    "base_joints": "Gelenke der Basis",
    "platform_joints": "Gelenke der Plattform",
    "ring_joints": "Gelenke von Basis und Plattform",
    "lower_ends": "untere Enden der Stäbe",
    "upper_ends": "obere Enden der Stäbe",
    "bar_ends": "Enden der Stäbe",
    "rings_exchanged": "Basis und Plattform sind vertauscht",
    "home_below": "Die Grundstellung steht auf dem Kopf",
    "counted_from": "{what}: von einem anderen aus gezählt ({first} ist 1)",
    "half_angle_other_way": "{what}: Halbwinkel andersherum gemessen",
    "half_angle_full": "{what}: Der Halbwinkel ist der ganze Winkel",
    "half_angle_full_other_way": "{what}: Der Halbwinkel ist der ganze Winkel, andersherum gemessen",
    "half_angle_half": "{what}: Der Halbwinkel ist die Hälfte davon",
    "radius_full": "{what}: Der Radius ist ein Durchmesser",
    "radius_half": "{what}: Der Radius ist die Hälfte davon",
    "other_side": "{what}: auf der anderen Seite des Ursprungs, entlang z",
    "turned_60": "{what}: um 60 Grad verdreht",
    "turned_back_60": "{what}: um -60 Grad verdreht",
    "turned_180": "{what}: um 180 Grad verdreht",
    "radii_exchanged": "Radien vertauscht: {first}, {second}",
    "half_angles_exchanged": "Halbwinkel vertauscht: {first}, {second}",
    "radii_half_angles_exchanged": "Radien und Halbwinkel vertauscht: {first}, {second}",
    "heights_exchanged": "Höhen vertauscht: {first}, {second}",
    "bars_turned": "Die Stäbe sind um {angle} Grad um z verdreht",
    "on_a_slope": "Die Schwerkraft zeigt {away} Grad neben gravity_m_s2: Die Maschine steht schräg",
    "gravity_along": "Die Schwerkraft zeigt entlang {word} von {{B}}",
}
"""Mistakes in the drawing of the machine, and where it stands."""

PROGRAMS = {
    "override_faster": "Ein Vorschub-Override über 100 % macht es schneller, als bewiesen ist; {remedy}",
    "override_linuxcnc": "M50 P0 vor die erste Bewegung schreiben, oder den Knopf bei 100 % enden lassen "
    "(MAX_FEED_OVERRIDE = 1)",
    "override_sinumerik": "höchstens 100 % lassen, oder den Knopf dort enden lassen (MD12030)",
    "override_twincat": "höchstens 100 % lassen, oder ihn in der SPS dort enden lassen",
}
"""Remarks on programs."""

SENTENCES = PROGRAMS | CAUSES | CHANNELS | MOTION | MACHINE
"""Code -> German, with the places of the English text."""

SIGNS = {"or": " oder ", "and": ", und ", "comma": ", ", "semicolon": "; "}
"""What stands between the parts of an enumeration."""
