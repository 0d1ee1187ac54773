"""German for what residuals may follow, what would make it, and sizes that a run tells, by code.

Words of what is followed and of causes are in the dative, as sentences need them.
"""

TOLD = {
    "told_sizes": "Der Lauf sagt: {words}; geschätzt und berücksichtigt; {remedy}",
    "told_joint": "Gelenk {k} der {ring} liegt um {size} daneben, entlang {axis}",
    "told_bar": "das {end} Ende von Stab {k} liegt um {size} daneben, entlang {axis}",
    "told_sensor": "der Sensor liegt um {size} daneben, entlang seiner {axis}-Achse",
    "told_turned": "der Sensor ist auf seinem Flansch um {size} verdreht, um seine {axis}-Achse",
    "told_gravity": "die Schwerkraft ist um {size} größer",
    "told_tilted": "die Schwerkraft ist um {size} gegen ({way}) geneigt: die Basis steht schräg",
    "told_gain": "{name} zeigt {size} zu viel",
    "told_clock": "Sekunden der Aufzeichnung sind um {size} länger als wahre",
    "told_scale": "{name} bewegt sich {size} mehr, als der Geber sagt",
    "told_link": "{name} liegt um {size} daneben, entlang {axis} von {before}",
    "told_zero": "{name} steht um {size} weiter, als angezeigt wird",
    "true_rate": "die wahre Rate angeben",
    "mend_scale": "den Maßstab im Antrieb berichtigen",
    "mend_zero": "den Nullpunkt in der Steuerung berichtigen",
    "joint_named": "Gelenk {name}",
    "strut_numbered": "Strebe {number}",
    "base": "Basis",
    "platform": "Plattform",
    "lower": "untere",
    "upper": "obere",
}
"""Sizes by which a machine is off its case."""

FOLLOWED = {
    "follows": "Die Residuen von {name} folgen {follow} ({part} von {whole} {unit} rms), wie bei {causes}",
    "and_follows": "{sentence}; der Rest folgt {others}",
    "allowed_for": "{sentence}. Die Abweichungen enthalten es: Die von {name} ist {times}-mal die durch Rauschen "
    "allein",
    "beside_model": "dem, was Modell {larger} mehr hat als Modell {own}",
    "load_on": "der Last auf {of}",
    "all_loads": "den Lasten auf allen Kanälen",
    "load_squared": "dem Quadrat der Last",
    "own_load_squared": "dem Quadrat seiner Last",
    "load_turning": "dem Drehen der Last",
    "gravity_acceleration": "Schwerkraft und Beschleunigung",
    "gravity_direction": "der Richtung der Schwerkraft",
    "constant_force": "einer gleichbleibenden Kraft entlang {of} der Basis",
    "position_along": "der Position entlang {of}",
    "speed_along": "der Geschwindigkeit entlang {of}",
    "sign_along": "dem Vorzeichen der Geschwindigkeit entlang {of}",
    "x_y_z": "x, y und z",
    "changing_delay": "einer Verzögerung, die sich mit der Zeit ändert",
    "rate_of_forces": "der Änderung der Kräfte",
    "own_rate": "seiner eigenen Änderung",
    "derivative_of_forces": "der {order} Ableitung der Kräfte",
    "derivative_of_own": "der {order} Ableitung seiner eigenen Kraft",
    "second": "zweiten",
    "third": "dritten",
    "fourth": "vierten",
    "sign_of_rate": "dem Vorzeichen der Änderung der Kräfte",
    "sign_of_own_rate": "dem Vorzeichen seiner eigenen Änderung",
    "load_changing": "einer Last, die sich mit der Zeit ändert",
    "load_leaping": "einer Last, die sich plötzlich ändert",
    "position_of": "der Position von {of}",
    "products_of": "Produkten der Position von {of}",
    "motion_of": "der Bewegung von {of}",
    "the_pose": "der Pose",
    "the_position": "der Position",
    "the_speed": "der Geschwindigkeit",
    "the_acceleration": "der Beschleunigung",
    "the_orientation": "der Orientierung",
    "drive_signs": "den Vorzeichen der Geschwindigkeiten der Antriebe",
    "sign_of_speed": "dem Vorzeichen der Geschwindigkeit von {of}",
    "speed_of": "der Geschwindigkeit von {of}",
    "acceleration_of": "der Beschleunigung von {of}",
    "gravity_in_sensor": "der Schwerkraft entlang {of} des Sensors",
    "speed_about": "der Drehgeschwindigkeit um {of} des Sensors",
    "acceleration_along": "der Beschleunigung entlang {of} des Sensors",
}
"""What residuals follow."""

MADE_BY = {
    "small_model": "einem zu kleinen Modell: {names} stehen nicht darin; Modell {number} wählen",
    "gain_high": "einer Verstärkung von {name}, die {size} % zu hoch ist",
    "by_coupling": "Übersprechen der Kanäle, oder einem falschen Maß der Sensorbasis",
    "not_linear": "Sensoren, die nicht linear sind",
    "ring_of_bars": "einem Maß, das {size} {unit} größer ist, als die Maschine nennt: {what} der Stäbe, {ring} Enden",
    "frame_further": "einer Sensorbasis, die {size} mm weiter entlang ihrer {axis}-Achse liegt, als {than} sagt",
    "accelerometer": "der Beschleunigungssensor",
    "case_says": "die Maschine",
    "frame_turned": "einer Sensorbasis, die um {size} Grad um ihre {axis}-Achse gegen {against} verdreht ist",
    "orientations": "die Orientierungen",
    "the_case": "ihre Angaben",
    "gravity_leans": "einer Schwerkraft, die um {size} Grad gegen ({along}) geneigt ist",
    "by_pull": "einem Schlauch oder Kabel, das zieht",
    "by_spring": "einem Schlauch, einem Kabel oder einer Feder zwischen der Last und ihrer Umgebung",
    "by_damper": "einem Dämpfer, oder einem Schlauch, der mitgezogen wird",
    "by_chain": "Reibung einer Kabelkette oder Dichtung",
    "stamps_apart": "Zeitstempeln, die {size} % zu weit auseinanderliegen",
    "clocks_drift": "Uhren von Kräften und Bewegung, die im Lauf um {size} ms auseinandergehen",
    "late_channels": "Kanälen, die gegeneinander verspätet sind",
    "by_low_pass": "einem Tiefpass in den Strömen, Rauschen der Antriebe, oder einer Eigenschwingung des Gestells "
    "unter der Grenzfrequenz",
    "by_hysteresis": "einer Hysterese der Sensoren",
    "by_payload": "einer Nutzlast, die verloren, aufgenommen oder verschoben wurde",
    "zero_wrong": "einem Nullpunkt von {name}, der um {size} {unit} falsch ist",
    "scale_wrong": "einem Maßstab von {name}, der um {size} % falsch ist",
    "zeros_wrong": "Nullpunkten aller Streben, die um {size} mm falsch sind",
    "scales_wrong": "einem Maßstab aller Streben, der um {size} % falsch ist",
    "by_drives": "Reibung in Gelenken oder Antrieben",
    "ring_of_joints": "einem Maß, das {size} {unit} größer ist, als die Maschine nennt: {what} der Gelenke, {ring}",
    "radius": "Radius",
    "half_angle": "Halbwinkel",
    "height": "Höhe",
    "by_place": "einem falschen Maß oder Nullpunkt in den Angaben, einem elastischen Gestell, oder Fehlern von "
    "Gebern und Gelenken",
    "by_orientation": "Fehlern der Orientierungen, oder Sensoren, die nicht gerade stehen",
    "by_shaking": "einer Verstärkung, einer Eigenschwingung dessen, was den Sensor trägt, oder einem Tiefpass in einem "
    "der Ströme",
    "by_rate": "Reibung, gegeneinander verspäteten Kanälen, oder einem Kabel",
    "by_acceleration": "einem falschen Maß in den Angaben, einer Verstärkung, einer Eigenschwingung des Gestells, oder "
    "einem Tiefpass in einem der Ströme",
}
"""What would make it."""

EFFECTS = TOLD | FOLLOWED | MADE_BY
"""All of them."""
