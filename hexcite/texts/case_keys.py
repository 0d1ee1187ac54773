"""German words for keys and tables of a case file, by class and key; the English ones stand in the classes."""

NOUNS: dict[str, str] = {
    "acceleration": "Beschleunigung",
    "acceleration headroom": "Beschleunigungsreserve",
    "acceleration noise": "Rauschen der Beschleunigung",
    "angle sign b": "Vorzeichen von B",
    "angles": "Winkel",
    "angular acceleration": "Winkelbeschleunigung",
    "angular acceleration noise": "Rauschen der Winkelbeschleunigung",
    "angular jerk": "Winkelruck",
    "angular velocity": "Winkelgeschwindigkeit",
    "at": "Ort",
    "average": "Mittelungszeit",
    "axis": "Achse",
    "azimuth": "Azimut",
    "bars": "Stäbe",
    "base joint angle": "Winkel am Basisgelenk",
    "block": "Satzdauer",
    "body": "Körper",
    "centre of gravity": "Schwerpunkt",
    "centre of gravity U": "U des Schwerpunkts",
    "clock": "Uhr",
    "command interfaces": "Kommandoschnittstellen",
    "common gain": "gemeinsame Verstärkung",
    "conditions": "Bedingungen",
    "contour tolerance": "Konturtoleranz",
    "controller": "Steuerung",
    "controller keeps": "Steuerung hält ein",
    "corners": "Ecken",
    "coulomb friction": "Coulombsche Reibung",
    "cycle": "Takt",
    "decelerate on cancel": "Abbremsen bei Abbruch",
    "duration": "Dauer",
    "each": "jede für sich",
    "encoder rate": "Geberrate",
    "encoder resolution": "Geberauflösung",
    "encoder resolution mdeg": "Geberauflösung, mdeg",
    "encoder scale": "Gebermaßstab",
    "filter cutoff": "Grenzfrequenz des Filters",
    "force": "Kraft",
    "force delay": "Verzug der Kräfte",
    "force noise": "Rauschen der Kraft",
    "force sampling offset cycles": "Versatz der Kraftabtastung",
    "from": "von",
    "gain": "Verstärkung",
    "goal time": "Zielzeit",
    "goal tolerance": "Zieltoleranz",
    "gravity": "Schwerkraft",
    "half angle": "halber Winkel",
    "home": "Grundstellung",
    "included angle": "ganzer Winkel",
    "inertia": "Trägheit",
    "interpolate from desired state": "Beginn beim letzten Sollwert",
    "interpolation": "Interpolation",
    "jerk": "Ruck",
    "joint states": "Topic der Gelenke",
    "joint zeros": "Gelenknullpunkte",
    "links": "Glieder",
    "joints": "Gelenke",
    "k0 N m": "k0, N/m",
    "k1 Nm m": "k1, N m/m",
    "kind": "Art",
    "kinematic id": "Nummer der Kinematik",
    "laboratory": "Aussteller",
    "lower": "unten",
    "mass": "Masse",
    "mass U": "U der Masse",
    "max linear jerk mm s3": "größter Ruck der Bahn, mm/s³",
    "mode": "Eigenfrequenz",
    "mode damping": "Dämpfung",
    "moment noise": "Rauschen des Moments",
    "most": "höchstens",
    "most blocks": "Sätze höchstens",
    "most override": "Override höchstens",
    "most rows": "Zeilen höchstens",
    "mounting": "Einbaulage",
    "name": "Name",
    "nanoseconds": "Nanosekunden",
    "noise times": "Vielfaches des Rauschens",
    "offset": "Nullpunkt",
    "offsets": "Nullpunkte",
    "operator": "Bediener",
    "orientation axes": "Orientierungsachsen",
    "orientation tolerance": "Orientierungstoleranz",
    "orientation words": "Orientierungswörter",
    "origin": "Ursprung",
    "pair centres": "Mitten der Paare",
    "path": "Bahn",
    "path deviation": "Bahnabweichung",
    "path error": "Bahnfehler",
    "path tolerance": "Bahntoleranz",
    "period": "Zeilenabstand",
    "plan for": "planen für",
    "planner": "Bahnplaner",
    "platform joint angle": "Winkel am Plattformgelenk",
    "points": "Punkte",
    "poly axes": "Achsen je POLY",
    "poly block": "Dauer eines POLY-Satzes",
    "poly degree": "Grad der POLY",
    "poly tolerance": "Toleranz der POLY",
    "pose error": "Posenfehler",
    "pose error angle": "Winkel des Posenfehlers",
    "pose error length": "Strecke des Posenfehlers",
    "pose error of load": "Posenfehler durch Last",
    "pose error seed": "Zufallszahl des Posenfehlers",
    "position": "Position",
    "program name": "Programmname",
    "radius": "Radius",
    "range": "Messbereich",
    "rate": "Rate",
    "rod first moment": "statisches Moment der Stange",
    "rod mass": "Masse der Stange",
    "rpy": "Drehung (rpy)",
    "safe feed": "sicherer Vorschub",
    "safe speed": "sicheres Tempo",
    "scale": "Maßstab",
    "sense": "Richtungssinn",
    "sensor": "Sensor",
    "serial numbers": "Seriennummern",
    "settle": "Beruhigungszeit",
    "setup": "Aufbau",
    "shortest block": "kürzester Satz",
    "singularity distance": "Abstand von Singularitäten",
    "slope": "Rampe",
    "source": "Quelle",
    "speed scaling": "Skalierung der Geschwindigkeit",
    "state interfaces": "Zustandsschnittstellen",
    "strut acceleration": "Strebenbeschleunigung",
    "strut length": "Strebenlänge",
    "strut radius": "Strebenradius",
    "strut velocity": "Strebengeschwindigkeit",
    "strut velocity band": "Band der Welligkeit",
    "strut velocity noise": "Welligkeit der Streben",
    "tilt": "Kippung",
    "title": "Titel",
    "to": "bis",
    "torque": "Drehmoment",
    "torsion": "Torsion",
    "trace": "Trace",
    "track deviation": "Winkelabweichung",
    "transformation": "Transformation",
    "transformation off": "Transformation aus",
    "travel": "Weg",
    "trigger off m": "M für Trigger aus",
    "trigger on m": "M für Trigger ein",
    "trigger output": "Ausgang des Triggers",
    "tube first moment": "statisches Moment des Rohrs",
    "unit": "Einheit",
    "upper": "oben",
    "velocity": "Geschwindigkeit",
    "viscous friction": "viskose Reibung",
    "weights": "Gewichtung",
}
"""The noun of a key, which is its English name without the unit -> German."""

KEYS: dict[str, str] = {
    "Heading.title": "Was es ist, in einer Zeile.",
    "Case.setup": (
        "Wo die Kraftsensoren sind: 1a in einem Gestell, das steht, 1b in der bewegten Plattform, 2x in den Streben, "
        "R ein Kraft-Momenten-Sensor; die Nummern sind die in Bild 1 des Aufsatzes."
    ),
    "Case.gravity_m_s2": "Fallbeschleunigung in {B}.",
    "Joints.points_mm": "[x, y, z] jedes Gelenks, in der Reihenfolge der Streben.",
    "Ring.radius_mm": "Radius des Kreises.",
    "Ring.half_angle_deg": "Winkel zwischen der Mitte eines Paars und jedem seiner beiden Gelenke.",
    "Ring.included_angle_deg": "Winkel zwischen den beiden Gelenken eines Paars.",
    "Ring.pair_centres_deg": "Richtungen der Mitten der drei Paare, von x nach y.",
    "Ring.angles_deg": "Richtungen der sechs Gelenke, von x nach y.",
    "Ring.z_mm": "Höhe des Kreises in seinem Koordinatensystem.",
    "Bars.sense": (
        'Was ein positiver Messwert bedeutet: `"compression"`, der Stab drückt seine Enden auseinander, oder '
        '`"tension"`, er zieht sie zusammen; einmal für alle Stäbe oder als Liste von sechs in der Reihenfolge der '
        "Kanäle."
    ),
    "StrutSensors.at": (
        "An welchem Ende der Stange ihr Sensor sitzt: zwischen Antrieb und Stange oder zwischen Stange und "
        "Plattformgelenk."
    ),
    "StrutSensors.each": "Ob jede Strebe eigene Parameter hat; sonst sind alle gleich.",
    "StrutSensors.rod_mass_kg": (
        "Masse einer Stange, Nennwert wie alles Folgende: Vorhersagen und simulierte Läufe rechnen damit."
    ),
    "StrutSensors.rod_first_moment_kg_m": "Statisches Moment der Stange, vom Plattformgelenk zum Basisgelenk.",
    "StrutSensors.tube_first_moment_kg_m": "Statisches Moment des Rohrs, vom Basisgelenk zum Plattformgelenk.",
    "StrutSensors.inertia_kg_m2": (
        "Summe der Trägheitsmomente der Stange um das Plattformgelenk und des Rohrs um das Basisgelenk."
    ),
    "StrutSensors.viscous_friction_Nms": (
        "Viskose Reibung in Basis- und Plattformgelenken; gehört zum Modell, wenn sie angegeben ist."
    ),
    "StrutSensors.coulomb_friction_Nm": (
        "Reibung in denselben Gelenken, unabhängig von der Geschwindigkeit; gehört zum Modell, wenn sie angegeben ist."
    ),
    "Transducer.sense": (
        "Welche Kraft ein positiver Messwert bedeutet: die der Last auf den Sensor (load) oder ihre Gegenkraft "
        "(reaction). Auswertung und Vorhersage brauchen das."
    ),
    "Frame.origin_mm": "Sein Ursprung im Koordinatensystem davor.",
    "Frame.rpy_deg": "Roll-, Nick- und Gierwinkel seiner Achsen, um feste Achsen, in dieser Reihenfolge.",
    "Sensors.range_N": "Größte Kraft, die ein Sensor misst; Pläne nutzen höchstens 80 % davon.",
    "Sensors.range_Nm": "Größtes Moment, das ein Kraft-Momenten-Sensor misst; ohne Angabe die Zahl von `range_N`.",
    "Sensors.weights": (
        "`equal`: W = 1 (gleiche Sensoren); `per_channel`: W aus der Residuenvarianz jedes Kanals; `per_unit`: aus "
        "der aller Kräfte und der aller Momente (ein Kraft-Momenten-Sensor, dessen Residuen mehr als sein Rauschen "
        "sind); `stated`: aus dem hier genannten Rauschen der Kräfte und Beschleunigungen, durch das Modell."
    ),
    "Sensors.force_noise_N": "Standardabweichung des weißen Rauschens einer Kraft, eines aufgezeichneten Werts.",
    "Sensors.moment_noise_Nm": (
        "Dasselbe für die Momente eines Kraft-Momenten-Sensors; beide werden zusammen angegeben."
    ),
    "Sensors.acceleration_noise_m_s2": (
        "Standardabweichung weißer Beschleunigungen des Ursprungs von {P}, welche die aufgezeichneten Streben "
        "nicht zeigen, je Wert und Richtung: Schwingung der Struktur."
    ),
    "Sensors.angular_acceleration_noise_rad_s2": (
        "Standardabweichung weißer Winkelbeschleunigungen der Plattform, welche die aufgezeichneten Streben nicht "
        "zeigen, je Wert und Richtung: Schwingung der Struktur."
    ),
    "Sensors.pose_error_N": (
        "Standardabweichung von Kraftfehlern, die von der Pose abhängen (Geber, Gelenke, Gestell), in jedem "
        "Sensor; wird mit ihrer Länge zusammen angegeben."
    ),
    "Sensors.pose_error_length_mm": (
        "Abstand im Raum der sechs Strebenlängen (Wurzel der Quadratsumme), bei dem sie noch halb gleich sind."
    ),
    "Poses.settle_s": "Wartezeit an jeder Pose, bevor gemittelt wird.",
    "Poses.average_s": "Zeit, über die an jeder Pose gemittelt wird.",
    "Poses.x_mm": (
        "Raster der Positionen relativ zur Grundstellung: [erste, letzte, Schritt]; ein Hexapod braucht es und "
        "alles Folgende."
    ),
    "Poses.y_mm": (
        "Raster der Positionen relativ zur Grundstellung: [erste, letzte, Schritt]; ein Hexapod braucht es und "
        "alles Folgende."
    ),
    "Poses.z_mm": (
        "Raster der Positionen relativ zur Grundstellung: [erste, letzte, Schritt]; ein Hexapod braucht es und "
        "alles Folgende."
    ),
    "Poses.radius_mm": "Abstand von der Grundstellung in der XY-Ebene: Punkte weiter außen entfallen.",
    "Poses.tilt_deg": "Raster der Kippwinkel: [erster, letzter, Schritt].",
    "Poses.azimuth_deg": "Raster der Richtungen des Kippens: [erste, letzte, Schritt].",
    "Poses.torsion_deg": "Raster der Drehungen um die gekippte z-Achse: [erste, letzte, Schritt].",
    "Poses.singularity_distance": (
        "Kleinste Determinante der inversen Jacobi-Matrix, als Anteil der in der Grundstellung."
    ),
    "Controller.block_ms": "Dauer der Sätze, in denen eine dichte Bahn geschrieben wird.",
    "Controller.safe_feed_mm_min": (
        "Größter Vorschub der ersten Bewegung eines Hexapods in einem Programm, das den Ort nicht prüft."
    ),
    "Controller.safe_speed_percent": (
        "Anteil der Geschwindigkeiten und Beschleunigungen von `[limits.motion]` für die erste Bewegung einer "
        "Kette in einem Programm, das den Ort nicht prüft."
    ),
    "Controller.settle_s": "Stillstand, bevor der Trigger ein- und nachdem er ausgeht.",
    "Controller.cycle_ms": "Interpolationstakt der Steuerung. Phasen geplanter Bewegungen dauern drei davon oder mehr.",
    "Controller.most_override_percent": (
        "Größter Vorschub-Override, den man drehen kann. Beweise gelten bis 100 %: Wenn dieser Schlüssel nicht "
        "sagt, dass der Drehknopf dort endet, schalten LinuxCNC-Programme den Override ab, und solche für "
        "SINUMERIK und TwinCAT haben einen Hinweis."
    ),
    "Controller.plan_for": (
        "Die Steuerung, für deren Zeitgesetz Punkt-zu-Punkt-Pläne entstehen (`hexcite plan --for`). Ohne sie "
        "gelten alle Grenzen von `[limits.motion]`, auch die des Rucks."
    ),
    "Tolerances.joints_mm": "Jede Koordinate jedes Gelenks von Basis und Plattform.",
    "Tolerances.bars_mm": "Jede Koordinate jedes Stabendes.",
    "Tolerances.sensor_mm": "Jede Koordinate des Ursprungs eines Kraft-Momenten-Sensors gegenüber der Angabe.",
    "Tolerances.sensor_deg": "Die Achsen eines Kraft-Momenten-Sensors, um jede von ihnen.",
    "Tolerances.joint_zeros_deg": "Die Nullstellung jedes drehenden Gelenks einer Kette.",
    "Tolerances.joint_zeros_mm": "Die Nullstellung jedes schiebenden Gelenks einer Kette.",
    "Tolerances.links_mm": (
        "Jede Koordinate des Ortes jedes Gelenks einer Kette außer dem ersten gegenüber dem Gelenk davor: Längen der "
        "Glieder und Abstände der Achsen."
    ),
    "Tolerances.encoder_scale_ppm": "Der Maßstab jedes Gebers.",
    "Tolerances.gain_percent": "Die Verstärkung jedes Kanals für sich.",
    "Tolerances.common_gain_percent": (
        "Eine Verstärkung, die alle Kanäle gemeinsam haben: Kein Lauf zeigt sie, Massen sind um so viel falsch."
    ),
    "Tolerances.gravity_deg": "Die Richtung der Schwerkraft, um jede waagrechte Achse: Die Maschine steht schief.",
    "Tolerances.gravity_percent": "Die Größe der Schwerkraft.",
    "Tolerances.clock_ppm": "Der Gang der Uhr, die den Lauf aufzeichnete.",
    "Bounds.mass_kg": "Kleinste und größte Masse.",
    "Bounds.centre_of_gravity_mm": "Quader in {P}, in dem der Schwerpunkt liegt; ohne Angabe gilt `body_mm`.",
    "BodyBox.x_mm": "Von und bis entlang x.",
    "BodyBox.y_mm": "Von und bis entlang y.",
    "BodyBox.z_mm": "Von und bis entlang z.",
    "Bounds.body_mm": "Quader in {P}, in dem der ganze Körper liegt: begrenzt auch die Trägheitsmomente.",
    "Acceptance.noise_times": (
        "Größtes Rauschen eines Kanals nach seinen Residuen, als Vielfaches der Angabe in [sensors]."
    ),
    "Acceptance.mass_percent": "Größte Abweichung der Masse von der in [nominal].",
    "Acceptance.path_percent": "Kleinster Anteil der geplanten Bahn, der im Lauf ist.",
    "Acceptance.duration_percent": "Größte Abweichung der Dauer von der des Plans.",
    "Acceptance.path_error_mm": "Größter Abstand der gefahrenen von der geplanten Bahn, wenn der Lauf sie nennt.",
    "LargestDeviations.mass_kg": "Der Masse.",
    "LargestDeviations.centre_of_gravity_mm": "Jeder Koordinate des Schwerpunkts.",
    "LargestDeviations.inertia_kg_m2": "Jedes Trägheits- und Deviationsmoments um den Schwerpunkt.",
    "LargestDeviations.offset_N": "Des Nullpunkts jedes Kraftkanals.",
    "LargestDeviations.offset_Nm": "Des Nullpunkts jedes Momentenkanals.",
    "Reference.mass_kg": "Ihre Masse.",
    "Reference.mass_U_kg": "Erweiterte Unsicherheit (k = 2) ihrer Masse.",
    "Reference.centre_of_gravity_mm": "Ihr Schwerpunkt in {P}.",
    "Reference.centre_of_gravity_U_mm": "Erweiterte Unsicherheit (k = 2) jeder seiner Koordinaten.",
    "CertificateOf.laboratory": "Wer es ausstellt: Name und Ort.",
    "CertificateOf.operator": "Wer den Lauf aufgezeichnet und ausgewertet hat.",
    "CertificateOf.serial_numbers": "Seriennummern der Teile: Maschine, Sensoren, Verstärker.",
    "CertificateOf.conditions": "Bedingungen des Laufs: Temperatur, Warmlauf, Werkzeug, Schläuche.",
    "RigidBody.mass_kg": "Masse.",
    "RigidBody.centre_of_gravity_mm": "Schwerpunkt in {P}.",
    "RigidBody.inertia_kg_m2": "I11, I12, I13, I22, I23, I33 wie in (17).",
    "RecordingFormat.filter_cutoff_Hz": (
        "Tiefpass ohne Phase, gleich auf Kräfte und Streben; nötig, wo Beschleunigungen durch Ableiten entstehen."
    ),
    "RecordingFormat.rate_Hz": (
        "Zeilen je Sekunde der Aufzeichnungen, oder Mittel aus so vielen: worauf vorhergesagte "
        "Standardabweichungen bauen."
    ),
    "Chain.may_touch": (
        'Paare von Körpern mit ihren Namen, die nicht auseinandergehalten werden: `[["forearm", "hand"]]`. Die eines '
        "Gliedes oder zweier, die ein Gelenk verbindet, brauchen nicht genannt zu werden."
    ),
    "Joint.name": "Name des Gelenks wie in ROS; Meldungen nennen ihn.",
    "Joint.kind": "Dreht zwischen Enden (revolute), dreht endlos (continuous) oder schiebt (prismatic).",
    "Joint.axis": "Achse im eigenen Koordinatensystem des Gelenks, beliebig lang.",
    "Joint.position_deg": "Unteres und oberes Ende des Gelenks.",
    "Joint.position_mm": "Unteres und oberes Ende des Gelenks.",
    "Joint.home_deg": "Wo Programme beginnen und enden; Grenzen der Bewegung zählen von dort.",
    "Joint.home_mm": "Wo Programme beginnen und enden; Grenzen der Bewegung zählen von dort.",
    "Joint.force_N": "Größte Kraft des Antriebs eines schiebenden Gelenks.",
    "Joint.torque_Nm": (
        "Größtes Drehmoment des Antriebs; Pläne nutzen höchstens 80 % davon, wenn jedes Gelenk sein Glied nennt."
    ),
    "JointLimit.name": "Name des Gelenks.",
    "JointLimit.position_deg": "Relativ zur Grundstellung.",
    "JointLimit.position_mm": "Relativ zur Grundstellung.",
    "JointLimit.velocity_deg_s": "Größte Geschwindigkeit.",
    "JointLimit.velocity_mm_s": "Größte Geschwindigkeit.",
    "JointLimit.acceleration_rad_s2": "Größte Beschleunigung; `acceleration_deg_s2` nennt sie in Grad.",
    "JointLimit.acceleration_deg_s2": "Größte Beschleunigung, in Grad.",
    "JointLimit.acceleration_m_s2": "Größte Beschleunigung.",
    "JointLimit.jerk_rad_s3": "Größter Ruck; `jerk_deg_s3` nennt ihn in Grad.",
    "JointLimit.jerk_deg_s3": "Größter Ruck, in Grad.",
    "JointLimit.jerk_m_s3": "Größter Ruck.",
    "Margin.travel_percent": "Anteil des Wegs von einem Ende zum anderen; 0: kein Abstand.",
    "Margin.most_mm": "Größter Abstand einer Länge.",
    "Margin.most_deg": "Größter Abstand eines Winkels: 0,1 Grad bewegen einen Punkt in einem halben Meter um 1 mm.",
    "Setpoints.cycle_ms": "Takt der Aufgabe, die sie vorgibt: ein ganzes Vielfaches des Takts der Antriebe.",
    "Setpoints.most_rows": "Was ihr Speicher fasst.",
    "Setpoints.controller_keeps": (
        "Grenzen, die sie einhält; wer Sollwerte nur an die Antriebe weitergibt, hält meist keine ein: `[]`."
    ),
    "Simulation.source": "Woher die Werte stammen.",
    "Disturbances.source": "Woher die Werte stammen.",
    "Payloads.source": "Woher die Werte stammen.",
    "Simulation.encoder_resolution_um": "Schritt der Geber von Streben und schiebenden Gelenken.",
    "Simulation.encoder_resolution_mdeg": "Schritt der Geber drehender Gelenke.",
    "Simulation.encoder_rate_Hz": "Werte der Streben je Sekunde.",
    "Simulation.force_noise_N": "Standardabweichung des weißen Rauschens eines Kraftwerts.",
    "Simulation.moment_noise_Nm": (
        "Standardabweichung eines Moments des Kraft-Momenten-Sensors; ohne Angabe die Zahl von `force_noise_N`."
    ),
    "Simulation.force_delay_ms": "Zeit, um die Kräfte später als die Bewegung aufgezeichnet werden.",
    "Simulation.force_sampling_offset_cycles": (
        "Wo zwischen zwei Werten der Streben die Kräfte abgetastet werden, als Anteil der Zeit dazwischen."
    ),
    "Truth.offsets_N": "Was die sechs Sensoren ohne Last anzeigen.",
    "Simulation.acceleration_noise_m_s2": (
        "Weiße Beschleunigungen der Plattform neben denen der Streben, wie in `Sensors`."
    ),
    "Simulation.angular_acceleration_noise_rad_s2": (
        "Weiße Winkelbeschleunigungen der Plattform neben denen der Streben, wie in `Sensors`."
    ),
    "Clock.unit": "Einheit eines Zeitstempels; `filetime`: 100 ns. Üblich s; bei `twincat-scope` ms.",
    "Clock.nanoseconds": "Name der zweiten Spalte der Zeitstempel, wenn es zwei sind: Sekunden und Nanosekunden dazu.",
    "Clock.period_ms": "Zeit zwischen den Zeilen, für Dateien ohne Zeitstempel.",
    "Clock.offset_s": (
        "Wird zu den Zeitstempeln gezählt: wenn Uhren ab verschiedenen Zeitpunkten zählen oder Stempel spät kommen."
    ),
    "Accelerometer.scale_m_s2": "Beschleunigung bei einem Messwert von 1.",
    "Accelerometer.mounting": "Drehung, Zeile für Zeile: spezifische Kraft in {P} = mounting mal Messwert.",
    "Pose.x_mm": "Position des Ursprungs von {P} in {B}.",
    "Pose.y_mm": "Position des Ursprungs von {P} in {B}.",
    "Pose.z_mm": "Position des Ursprungs von {P} in {B}.",
    "Pose.a_deg": "Rollen, um die feste Achse x; zuerst.",
    "Pose.b_deg": "Nicken, um die feste Achse y; danach.",
    "Pose.c_deg": "Gieren, um die feste Achse z; zuletzt.",
    "MotionLimits.x_mm": "Untere und obere Grenze relativ zur Grundstellung.",
    "MotionLimits.y_mm": "Untere und obere Grenze relativ zur Grundstellung.",
    "MotionLimits.z_mm": "Untere und obere Grenze relativ zur Grundstellung.",
    "MotionLimits.a_deg": (
        "Untere und obere Grenze von Rollen (a), Nicken (b) und Gieren (c) relativ zur Grundstellung."
    ),
    "MotionLimits.b_deg": (
        "Untere und obere Grenze von Rollen (a), Nicken (b) und Gieren (c) relativ zur Grundstellung."
    ),
    "MotionLimits.c_deg": (
        "Untere und obere Grenze von Rollen (a), Nicken (b) und Gieren (c) relativ zur Grundstellung."
    ),
    "StrutLengths.strut_length_mm": (
        "Kürzeste und längste Strebe, von Gelenkmitte zu Gelenkmitte; in `[limits.motion]` innerhalb der von "
        "`[workspace]`."
    ),
    "Workspace.x_mm": "Untere und obere Grenze in {B}; ohne Angabe begrenzen nur die Streben.",
    "Workspace.y_mm": "Untere und obere Grenze in {B}; ohne Angabe begrenzen nur die Streben.",
    "Workspace.z_mm": "Dasselbe für die Höhe; ohne Angabe begrenzen nur die Streben.",
    "Workspace.base_joint_angle_deg": "Größter Winkel zwischen einer Strebe und der Normalen ihres Basisgelenks.",
    "Workspace.platform_joint_angle_deg": (
        "Größter Winkel zwischen einer Strebe und der Normalen ihres Plattformgelenks."
    ),
    "Workspace.strut_radius_mm": (
        "Radius der Streben, wo sie an den Quadern von `keep_out` vorbeigehen; 0: Linien von Gelenk zu Gelenk."
    ),
    "MotionLimits.velocity_mm_s": "Größte Geschwindigkeit in x, y und z.",
    "MotionLimits.angular_velocity_deg_s": "Größte Drehgeschwindigkeit von Rollen, Nicken und Gieren.",
    "MotionLimits.acceleration_m_s2": "Größte Beschleunigung in x, y und z.",
    "MotionLimits.angular_acceleration_rad_s2": (
        "Größte zweite Ableitung von Rollen, Nicken und Gieren; `angular_acceleration_deg_s2` nennt sie in Grad."
    ),
    "MotionLimits.angular_acceleration_deg_s2": "Größte zweite Ableitung von Rollen, Nicken und Gieren, in Grad.",
    "MotionLimits.jerk_m_s3": "Größter Ruck in x, y und z.",
    "MotionLimits.angular_jerk_rad_s3": (
        "Größte dritte Ableitung von Rollen, Nicken und Gieren; `angular_jerk_deg_s3` nennt sie in Grad."
    ),
    "MotionLimits.angular_jerk_deg_s3": "Größte dritte Ableitung von Rollen, Nicken und Gieren, in Grad.",
    "MotionLimits.strut_velocity_m_s": "Größte Geschwindigkeit einer Strebe.",
    "MotionLimits.strut_acceleration_m_s2": "Größte Beschleunigung einer Strebe.",
    "LinuxCnc.acceleration_headroom": (
        "Beschleunigungsgrenzen der Steuerung als Vielfaches von `[limits.motion]`. LinuxCNC blickt auf drehenden "
        "Bahnen nicht voraus: Bei 1 dehnt es dichte Bahnen, weit über 1 läuft es in der Zeit des Programms, und "
        "nur der Beweis des Programms sichert die Grenzen."
    ),
    "LinuxCnc.planner": (
        "`[TRAJ]PLANNER_TYPE` der Maschine: `trapezoidal` (0, das aller Versionen) oder `s_curve` (1, ab Version "
        "2.10), der den Ruck entlang der Bahn begrenzt und, durch `MAX_JERK` in `[AXIS_a]`, den jeder Achse. "
        "Programme dafür sind gerade Bewegungen von Ruhe zu Ruhe; keines wurde darauf erprobt."
    ),
    "SinumerikAxes.program_name": (
        "Interner Name: 2 bis 24 Großbuchstaben, Ziffern und Unterstriche; beginnt mit zwei Buchstaben oder `_` "
        "und einem Buchstaben."
    ),
    "Sinumerik.transformation": (
        "Was die Transformation einschaltet: `TRAORI`, `TRAORI(2)` oder der Name des Herstellers."
    ),
    "Sinumerik.transformation_off": "Was sie ausschaltet.",
    "Sinumerik.orientation_words": (
        "Rollen, Nicken, Gieren in den Sätzen: `A2 B2 C2` (geschrieben `A2=`, gelesen unter ORIRPY) oder `A B C`, "
        "wenn die Transformation die Winkel als Achsen nimmt."
    ),
    "Sinumerik.orientation_axes": "Namen der Achsen dahinter, für FGROUP( ) und PO[ ].",
    "Sinumerik.path": (
        "Bewegungen, die keine Geraden sind: Polynomsätze (POLY) oder dichte G1 mit dem Kompressor COMPCAD."
    ),
    "Sinumerik.poly_degree": "Grad der Polynome, den die Steuerung annimmt.",
    "Sinumerik.poly_axes": (
        "Wie viele Achsen ein POLY-Satz höchstens hat; weniger als sechs reichen für einen Hexapod nicht."
    ),
    "Sinumerik.poly_block_ms": (
        "Längster POLY-Satz. Kürzere Sätze lassen der Steuerung weniger zu entscheiden und kosten sie mehr davon "
        "je Sekunde."
    ),
    "Sinumerik.poly_tolerance_mm": (
        "Größter Abstand der POLY-Sätze von einer Bewegung, die kein Polynom ihres Grades beschreibt."
    ),
    "Sinumerik.poly_tolerance_deg": (
        "Größter Abstand der POLY-Sätze von einer Bewegung, die kein Polynom ihres Grades beschreibt."
    ),
    "Sinumerik.contour_tolerance_mm": "CTOL des Kompressors.",
    "Sinumerik.orientation_tolerance_deg": "OTOL des Kompressors.",
    "SinumerikAxes.trigger_output": "Nummer des digitalen Ausgangs $A_OUT, den eine Synchronaktion schaltet.",
    "BlockMemory.shortest_block_ms": "Takt der Steuerung, oder Satzwechselzeit: Kürzere Sätze lassen sie verhungern.",
    "BlockMemory.most_blocks": "Was ihr Programmspeicher fasst.",
    "BlockMemory.controller_keeps": (
        "Grenzen, welche die Steuerung in dem, was sie zeitlich führt, selbst einhält; was hier nicht steht, ist "
        "`NOT enforced`."
    ),
    "SinumerikAxes.trace": (
        "Ob das Programm die Aufzeichnung der Steuerung startet und beendet, mit $AN_SLTRACE = 1 und 2. Die "
        "Sitzung muss an der Steuerung vorbereitet sein, mit dieser Variablen als Start und Stopp, und scharf "
        "geschaltet."
    ),
    "TwinCatAxes.program_name": "Name in der Zeile mit `%`.",
    "TwinCat.kinematic_id": (
        "Der Transformation des Hexapods: Kein Handbuch nennt eine, sie ist, was `trafo[i].id` sagt."
    ),
    "TwinCat.angle_sign_b": (
        "-1: B dreht negativ, R = Rz(C) Ry(-B) Rx(A) (P-CHAN-00112 = 0, die Voreinstellung). +1: Die Kinematik "
        "nimmt die Winkel als R = Rz(C) Ry(B) Rx(A). Vor allem anderen mit einem einzigen kleinen B probieren."
    ),
    "TwinCat.path": (
        "Dichte Bahnen: `#SPLINE TYPE AKIMA` durch die Punkte, `#HSC ON [BSPLINE ..]` oder `#CONTOUR MODE [DEV "
        "..]` in ihrer Nähe."
    ),
    "TwinCat.path_deviation_mm": "PATH_DEV von `#HSC` und `#CONTOUR MODE`.",
    "TwinCat.track_deviation_deg": "TRACK_DEV von `#HSC` und `#CONTOUR MODE`.",
    "TwinCatAxes.slope": "`#SLOPE TYPE`: TRAPEZ begrenzt den Ruck, STEP nicht.",
    "TwinCatAxes.trigger_on_m": (
        "M-Funktionen, aus denen die SPS die beiden Enden des Triggers macht; sie brauchen eine "
        "Synchronisationsart (P-CHAN-00041)."
    ),
    "TwinCatAxes.trigger_off_m": (
        "M-Funktionen, aus denen die SPS die beiden Enden des Triggers macht; sie brauchen eine "
        "Synchronisationsart (P-CHAN-00041)."
    ),
    "Disturbances.mode_Hz": (
        "Eigenfrequenz zwischen Antrieben und Plattform ohne Nutzlast; sie fällt mit der Wurzel der bewegten Masse."
    ),
    "Disturbances.mode_damping": "Anteil der kritischen Dämpfung.",
    "Disturbances.strut_velocity_noise_percent": (
        "Effektivwert der Geschwindigkeitswelligkeit der Streben, welche die Plattform wirklich bewegt, als Anteil "
        "der Geschwindigkeit jeder Strebe."
    ),
    "Disturbances.strut_velocity_band_Hz": "Höchste Frequenz dieser Welligkeit.",
    "Disturbances.pose_error_N": (
        "Effektivwert des Kraftfehlers, der von der Pose abhängt, in jedem Sensor, ohne Nutzlast."
    ),
    "Disturbances.pose_error_of_load": (
        "Derselbe durch eine Nutzlast, als Anteil ihres Gewichts; unabhängig vom Fehler ohne Nutzlast."
    ),
    "Disturbances.pose_error_length_mm": "Strecke, über die sich der Fehler ändert, bei Verschiebungen.",
    "Disturbances.pose_error_angle_deg": "Winkel, über den sich der Fehler ändert, bei Drehungen.",
    "Disturbances.pose_error_seed": "Wählt den Fehler dieser Maschine: Er gehört zur Maschine, nicht zu einem Lauf.",
    "Compensation.k0_N_m": "Kraft je Meter Verschiebung in x und y.",
    "Compensation.k1_Nm_m": "Moment je Meter Verschiebung in x und y.",
    "Compensation.k2_N": "Kraft je Radiant Kippung.",
    "Compensation.k3_Nm": "Moment je Radiant Kippung.",
    "Tool.name": "Was es ist; Meldungen nennen es.",
    "Tool.from_mm": "Ein Ende seiner Achse in {P}, wie `to_mm`.",
    "Tool.to_mm": "Das andere Ende; entfällt, wo `corners_mm` angegeben sind.",
    "Tool.corners_mm": (
        "Ecken eines konvexen Körpers in {P}, an Stelle einer Achse. Bei Maschinen mit Streben zählt die Kapsel darum."
    ),
    "Tool.radius_mm": "Radius um diese Achse, oder um wie viel der konvexe Körper ringsum größer ist.",
    "KeepOut.name": "Was dort steht; Meldungen nennen es.",
    "KeepOut.x_mm": "Untere und obere Grenze in {B}; ohne Angabe hat er kein Ende.",
    "KeepOut.y_mm": "Untere und obere Grenze in {B}; ohne Angabe hat er kein Ende.",
    "KeepOut.z_mm": "Untere und obere Grenze in {B}; ohne Angabe hat er kein Ende.",
    "UrScript.program_name": "Name der Funktion, die das Programm ist: Buchstaben, Ziffern und Unterstriche.",
    "UrScript.trigger_output": (
        "Digitaler Ausgang, der während der Bewegung ein ist; RTDE zeichnet ihn mit der Uhr des Roboters auf."
    ),
    "Ros2.controller": "Name der Steuerung (controller) in ROS 2.",
    "Ros2.joint_states": "Topic der Gelenkpositionen.",
    "Ros2.interpolation": (
        "Ihr `interpolation_method`: `splines` verbindet Punkte mit Beschleunigungen durch Polynome fünften "
        "Grades, `none` (seit Galactic) springt von Punkt zu Punkt."
    ),
    "Ros2.path_tolerance_deg": (
        "Ihr `constraints.<joint>.trajectory`: Sie hält an, wo ein Gelenk weiter von seiner Bahn ist."
    ),
    "Ros2.path_tolerance_mm": (
        "Ihr `constraints.<joint>.trajectory`: Sie hält an, wo ein Gelenk weiter von seiner Bahn ist."
    ),
    "Ros2.goal_tolerance_deg": "Ihr `constraints.<joint>.goal`.",
    "Ros2.goal_tolerance_mm": "Ihr `constraints.<joint>.goal`.",
    "Ros2.goal_time_s": (
        "Ihr `constraints.goal_time`: wie spät das Ziel erreicht sein darf; ohne Angabe wartet sie endlos."
    ),
    "Ros2.controller_keeps": "Grenzen, die ros2_control dahinter einhält (`enforce_command_limits`); üblich keine.",
    "Ros2.command_interfaces": (
        "Ihre `command_interfaces`. Ohne Positionen folgt ein eigener Regelkreis den Sollwerten, mehr oder weniger."
    ),
    "Ros2.state_interfaces": (
        "Ihre `state_interfaces`: Was die Hardware von einem Gelenk meldet, entscheidet, wie glatt der Weg zum ersten "
        "Punkt ist."
    ),
    "Ros2.interpolate_from_desired_state": (
        "Ob sie bei ihrem letzten Sollwert beginnt (bis 2025 `open_loop_control`) statt dort, wo die Gelenke sind."
    ),
    "Ros2.decelerate_on_cancel": (
        "Ihr `constraints.decelerate_on_cancel`: ob sie abbremst, wo eine Bewegung abgebrochen wird oder von ihrer "
        "Bahn abkommt. Dazu braucht sie Geschwindigkeiten unter ihren `state_interfaces` und von jedem Gelenk "
        "`max_deceleration_on_cancel` über 0."
    ),
    "Ros2.speed_scaling": (
        "Ob ein Regler der Geschwindigkeit Bahnen dehnt: eine scaled-Steuerung oder `speed_scaling.state_interface`."
    ),
    "LinuxCnc.max_linear_jerk_mm_s3": (
        "Bei `s_curve`: `[TRAJ]MAX_LINEAR_JERK`, entlang X, Y, Z zusammen, in deg/s^3 entlang A, B, C, wo sich nur "
        "diese bewegen. Unter 1 fährt LinuxCNC Trapeze."
    ),
}
"""Class and key -> what it means."""

TABLES: dict[str, str] = {
    "Bars": (
        "Sechs einachsige Kraftsensoren, jeder in einem Stab, der die Plattform von einem unteren zu einem oberen "
        "Punkt trägt."
    ),
    "Sensors": "Eigenschaften der sechs Kanäle.",
    "Poses": (
        "Wie lange an Posen gemessen wird, und bei einem Hexapod das Raster der Kandidaten; die einer Kette liegen "
        "in `[limits.motion]`. Winkel: R = Rz(Azimut) Ry(Kippung) Rz(Torsion - Azimut); Positionen relativ zur "
        "Grundstellung."
    ),
    "Controller": "Einstellungen der Programme.",
    "Tolerances": (
        "Abweichungen der Maschine von dieser Beschreibung, jede für sich: `0.03`, eine Standardabweichung, oder "
        "`{ limit = 0.05 }`. Was nicht angegeben ist, wird nicht mitgezählt, und Ergebnisse sagen das."
    ),
    "Bounds": (
        "Grenzen des Körpers, den die Sensoren tragen, ohne Nutzlasten, wie CAD sie nennt; jede kann fehlen. "
        "Schätzungen wägen Masse und Schwerpunkt damit, solange sie nicht widersprechen."
    ),
    "Acceptance": "Grenzen, nach denen `hexcite accept` und `identify` ein Ergebnis beurteilen: bestanden oder nicht.",
    "LargestDeviations": "Größte Abweichungen der Parameter.",
    "Reference": "Eine Referenz, mit der die Parameter übereinstimmen müssen, E_n höchstens 1.",
    "CertificateOf": "Was Zertifikate dieser Maschine nennen; alles kann fehlen.",
    "RigidBody": "Masse, Schwerpunkt in {P} und Trägheit um den Schwerpunkt, Achsen von {P}.",
    "SensorFrame": (
        "Wo die Kräfte gemessen werden: in Stäben, in einem Kraft-Momenten-Sensor oder in den Streben; genau eines "
        "davon."
    ),
    "Transducer": "Ein sechsachsiger Kraft-Momenten-Sensor.",
    "StrutSensors": "Sechs Kraftsensoren in den Streben.",
    "RecordingFormat": (
        "Wie Aufzeichnungen dieser Maschine gelesen werden; Einheiten sind die der Beschriftungen, sonst die "
        "unserer Spaltennamen."
    ),
    "Clock": "Die Zeitstempel.",
    "Accelerometer": "Wo die Datei Werte eines Beschleunigungssensors hat.",
    "Joint": (
        "Ein Gelenk und das Glied dahinter, dessen Koordinatensystem das des Gelenks in der Stellung 0 ist. Ein "
        "`continuous` dreht endlos und hat kein `position_deg`; ein `revolute` hat eines, ein `prismatic` hat "
        "`position_mm`. Die Auswertung braucht weder Enden noch Grundstellung; Grenzen der Bewegung brauchen "
        "beide."
    ),
    "Chain": "Gelenke von der Basis zum Sensor.",
    "Frame": "Ein Koordinatensystem im vorigen.",
    "JointLimit": (
        "Was eine Bewegung von einem Gelenk nutzen darf; Grad und Radiant, wo es dreht, sonst Millimeter und Meter."
    ),
    "JointMotionLimits": "Was Bewegungen von den Gelenken nutzen dürfen.",
    "Margin": (
        "Was gesuchte Bewegungen vor jedem Ende eines Wegs frei lassen: von Achsen, Gelenken, Streben, "
        "Bewegungsbereichen. Ein Anteil des Wegs, aber nicht mehr als eine Länge oder ein Winkel. Der Beweis "
        "urteilt nach den Grenzen selbst."
    ),
    "Limits": "Was Bewegungen nutzen dürfen.",
    "Setpoints": "Einstellungen von Sollwerttabellen für externe Sollwertvorgabe.",
    "Simulation": "Die simulierte Maschine: ihre Parameter und wie unvollkommen sie misst.",
    "Disturbances": "Was die simulierte Maschine stört.",
    "Truth": "Alle Parameter der simulierten Maschine.",
    "Compensation": "Faktoren der elastischen Verformung.",
    "Joints": "Sechs Punkte, einzeln oder als Ring; genau eines davon.",
    "Ring": "Gelenke auf einem Kreis, in drei Paaren.",
    "HexapodMachine": "Ein Hexapod: Strebe k verbindet Basisgelenk k mit Plattformgelenk k.",
    "SerialMachine": "Eine Kette von Gelenken.",
    "Pose": "Eine Pose der Plattform.",
    "Workspace": "Was die Maschine erreichen kann.",
    "MotionLimits": (
        "Der Bereich, in dem Bewegungen bleiben: Pose relativ zur Grundstellung und ihre Ableitungen, jede "
        "Koordinate. Die Grundstellung darf auf seinem Rand liegen. Von Winkelbeschleunigung und Winkelruck ist je "
        "ein Schlüssel nötig, in rad oder deg."
    ),
    "LinuxCnc": "Einstellungen der LinuxCNC-Konfiguration, die aus dieser Beschreibung entsteht.",
    "Sinumerik": (
        "Einstellungen von SINUMERIK-Programmen. Die Transformation eines Hexapods ist Sache des Herstellers: ihn "
        "nach diesen Wörtern fragen."
    ),
    "SinumerikAxes": "Einstellungen von SINUMERIK-Programmen.",
    "TwinCat": (
        "Einstellungen von Programmen für TF5200 und ISG. Kanalparameter heißen wie in den Handbüchern von Beckhoff."
    ),
    "TwinCatAxes": "Einstellungen von Programmen für TF5200 und ISG.",
    "Payloads": "Bekannte Gewichte, die nacheinander montiert werden, um eine Bestimmung zu prüfen.",
    "Tool": (
        "Ein Körper an der Plattform, ein Werkzeug oder Werkstück, der auch nicht in die Quader von `keep_out` darf. "
        "Er ist rund um eine Achse oder die konvexe Hülle einiger Ecken."
    ),
    "KeepOut": (
        "Ein Quader in {B}, in den weder Plattform, Streben noch Werkzeuge dürfen; nur `z_mm` ist ein Boden, nur "
        "`x_mm` eine Wand."
    ),
    "UrScript": "Einstellungen von Programmen für Roboter von Universal Robots.",
    "Ros2": "Wie die Steuerung der Gelenkbahnen eingestellt ist; nichts davon ist nötig.",
    "Case": "",
    "BodyBox": "Ein Quader in {P}.",
}
"""Class of a table -> what it is."""
