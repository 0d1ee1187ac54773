"""Names of columns as recorders of the field write them: each gets the right meaning or none, never a wrong one."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import pytest

from cases.orientation import ANGLES, QUATERNION, ROTATION
from cases.recording_format import ACCELEROMETER, BAR_FORCES, CLOCK, DRIVES, OVERRIDE, STRUTS, TRIGGER, WRENCH
from cases.schema import Case, load_case
from identification.recording.formats.names.meaning import meaning_of

XYZ = "xyz"
UR_JOINTS = ("base", "shoulder", "elbow", "wrist_1", "wrist_2", "wrist_3")


@cache
def machine(name: str) -> Case | None:
    """A built-in case, or one with seven joints or other names of them."""
    if name == "none":
        return None
    if name == "seven":
        data = load_case("ur10_wrist").model_dump(exclude_none=True)
        chain = data["machine"]["chain"]
        joints = [*chain["joints"], chain["joints"][0]]
        chain["joints"] = [joint | {"name": f"joint_{k}"} for k, joint in enumerate(joints, 1)]
        return Case.model_validate({key: data[key] for key in ("schema_version", "name", "title", "setup",
                                    "gravity_m_s2", "sensor_frame", "sensors", "recording", "machine")})  # fmt: skip
    return load_case(name)


def numbered(pattern: str, first: int = 1, count: int = 6) -> list[str]:
    return [pattern.replace("#", str(k)) for k in range(first, first + count)]


def vector(pattern: str, letters: Sequence[str] = XYZ) -> list[str]:
    return [pattern.replace("@", letter) for letter in letters]


@dataclass(frozen=True)
class Header:
    """A header line, the machine it is from, and what is right; columns that are not named mean nothing."""

    recorder: str
    machine: str
    names: tuple[str, ...]
    right: dict[str, str]
    clock: str | None = None  # the best candidate
    trigger: tuple[str, ...] = ()  # candidates
    override: tuple[str, ...] = ()
    orientation: str | None = None  # the first convention that is named
    doubt: str | None = None  # a word of a sentence that must be said


def header(recorder: str, on: str, *parts: Any, **said: Any) -> Header:
    """Parts: names that mean nothing, or pairs of our columns and the file's names for them, in the file's order."""
    names: list[str] = []
    right: dict[str, str] = {}
    for part in parts:
        if isinstance(part, tuple):
            ours, theirs = part
            right |= dict(zip(ours, theirs, strict=True))
            names += theirs
        else:
            names += [part] if isinstance(part, str) else part
    return Header(recorder, on, tuple(names), right, **said)


def wrench(force: str, moment: str, letters: Sequence[str] = XYZ) -> tuple[tuple[str, ...], list[str]]:
    return WRENCH, [*vector(force, letters), *vector(moment, letters)]


Q6 = tuple(f"q{k}_deg" for k in range(1, 7))
Q7 = tuple(f"q{k}_deg" for k in range(1, 8))
TABLE_AXES = ("q1_mm", "q2_mm", "q3_mm", "q4_deg", "q5_deg")
PLACE = ("x_mm", "y_mm", "z_mm")
UR, HEX, WRIST, TABLE = "ur10_wrist", "hexapod", "ft_wrist", "five_axis_table"

HEADERS = [
    # Universal Robots, RTDE
    header("RTDE", UR, "timestamp", numbered("target_q_#", 0), (Q6, numbered("actual_q_#", 0)),
           numbered("actual_qd_#", 0), numbered("actual_TCP_pose_#", 0), numbered("actual_TCP_force_#", 0),
           (WRENCH, numbered("ft_raw_wrench_#", 0)), "actual_digital_output_bits", "speed_scaling",
           clock="timestamp", trigger=("actual_digital_output_bits",), doubt="ft_raw_wrench"),
    header("RTDE", UR, "timestamp", (Q6, numbered("actual_q_#", 0)), numbered("actual_TCP_force_#", 0),
           numbered("actual_current_#", 0), numbered("target_moment_#", 0), numbered("joint_temperatures_#", 0),
           numbered("actual_joint_voltage_#", 0), clock="timestamp", doubt="actual_TCP_force_0"),
    header("RTDE", WRIST, "timestamp", ((*PLACE, *ANGLES), numbered("actual_TCP_pose_#", 0)),
           (WRENCH, numbered("ft_raw_wrench_#", 0)), clock="timestamp", orientation="rotation vector"),
    header("ur_rtde", UR, "timestamp", (Q6, numbered("actual_q_#", 0)), numbered("actual_qd_#", 0),
           numbered("actual_TCP_speed_#", 0), "actual_momentum", (WRENCH, numbered("ft_raw_wrench_#", 0)),
           clock="timestamp"),
    header("URCap log", UR, "Time", (Q6, numbered("Joint_#_actual")), numbered("Joint_#_target"),
           wrench("F@", "T@"), clock="Time"),
    # KUKA
    header("KUKA Sunrise DataRecorder", "seven", "ZeitInSec", "ZeitInNanoSec",
           (Q7, numbered("axisQMsr_LBR_iiwa_7_R800_1[#]", 0, 7)), numbered("axisTauMsr_LBR_iiwa_7_R800_1[#]", 0, 7),
           clock="ZeitInSec"),
    header("KUKA Sunrise DataRecorder", UR, "time", vector("cartForce1_@", "XYZ"), vector("cartTorque1_@", "XYZ"),
           numbered("axisQCmd_#"), (Q6, numbered("axisQMsr_#")), clock="time", doubt="Sunrise"),
    header("KUKA RSI", UR, "IPOC", vector("RIst.@", "XYZABC"), vector("RSol.@", "XYZABC"),
           (Q6, numbered("AIPos.A#")), numbered("ASPos.A#"), numbered("MACur.A#")),
    header("KUKA RSI", UR, "Zeit", (Q6, numbered("A#")), numbered("E#"), wrench("raw_f@", "raw_t@"), clock="Zeit"),
    header("KUKA trace", UR, "Zeit [ms]", (Q6, numbered("$AXIS_ACT.A#")), numbered("$VEL_AXIS_ACT[#]"),
           numbered("$TORQUE_AXIS_ACT[#]"), clock="Zeit [ms]"),
    header("KUKA trace", WRIST, "Zeit", ((*PLACE, *ANGLES), vector("$POS_ACT.@", "XYZABC")), wrench("F@", "M@"),
           clock="Zeit", orientation="zyx intrinsic"),
    header("KUKA FRI", "seven", "time", (Q7, numbered("msrJointPos#", 0, 7)), numbered("cmdJointPos#", 0, 7),
           numbered("msrJntTrq#", 0, 7), numbered("extEstJntTrq#", 0, 7), numbered("extEstCartForce#", 0, 6),
           clock="time", doubt="FRI"),
    # ABB, EGM
    header("ABB EGM", UR, "time", numbered("q#", 0, 4), (Q6, numbered("j#")), wrench("F@", "T@"), clock="time"),
    header("ABB EGM", UR, "sec", "usec", (Q6, numbered("feedback.joints.joints[#]", 0)),
           numbered("planned.joints.joints[#]", 0), (WRENCH, numbered("measuredForce.force[#]", 0))),
    header("ABB", WRIST, "time", (PLACE, vector("@")), (QUATERNION, numbered("q#", 1, 4)), wrench("f@", "t@"),
           clock="time", orientation="quaternion"),
    # Franka
    header("libfranka", UR, "time", (Q6, numbered("q[#]", 0)), numbered("q_d[#]", 0), numbered("dq[#]", 0),
           numbered("tau_J[#]", 0), (WRENCH, numbered("wrench[#]", 0)), clock="time"),
    header("libfranka", "seven", "time", (Q7, numbered("q[#]", 0, 7)), numbered("dq[#]", 0, 7),
           numbered("q_d[#]", 0, 7), numbered("tau_ext_hat_filtered[#]", 0, 7), numbered("O_F_ext_hat_K[#]", 0),
           numbered("K_F_ext_hat_K[#]", 0), clock="time", doubt="libfranka"),
    header("libfranka", "seven", "time", numbered("K_F_ext_hat_K_#", 0), clock="time", doubt="K_F_ext_hat_K_0"),
    header("franka log", "seven", "time [s]", (Q7, numbered("state.q[#]", 0, 7)), numbered("state.dq[#]", 0, 7),
           numbered("cmd.tau_J_d[#]", 0, 7), numbered("state.O_T_EE[#]", 0, 16), clock="time [s]"),
    # ROS
    header("rostopic echo -p", UR, "%time", "field.header.seq", "field.header.stamp", "field.header.frame_id",
           wrench("field.wrench.force.@", "field.wrench.torque.@"), clock="field.header.stamp"),
    header("rostopic echo -p", UR, "%time", "field.header.seq", "field.header.stamp", "field.header.frame_id",
           numbered("field.name#", 0), (Q6, numbered("field.position#", 0)), numbered("field.velocity#", 0),
           numbered("field.effort#", 0), clock="field.header.stamp"),
    header("bagpy", UR, "Time", "header.seq", "header.stamp.secs", "header.stamp.nsecs", "header.frame_id",
           numbered("name_#", 0), (Q6, numbered("position_#", 0)), numbered("velocity_#", 0),
           numbered("effort_#", 0)),
    header("bagpy", UR, "Time", "header.seq", "header.stamp.secs", "header.stamp.nsecs", "header.frame_id",
           wrench("wrench.force.@", "wrench.torque.@")),
    header("PlotJuggler", UR, "__time", (Q6, [f"/joint_states/{j}/position" for j in UR_JOINTS]),
           [f"/joint_states/{j}/velocity" for j in UR_JOINTS], [f"/joint_states/{j}/effort" for j in UR_JOINTS],
           wrench("/ft/wrench/force/@", "/ft/wrench/torque/@"), clock="__time"),
    header("PlotJuggler", UR, "__time", [f"/joint_states/{j}_joint/effort" for j in UR_JOINTS],
           (Q6, [f"/joint_states/{j}_joint/position" for j in UR_JOINTS]),
           wrench("/force_torque_sensor_broadcaster/wrench/wrench/force/@",
                  "/force_torque_sensor_broadcaster/wrench/wrench/torque/@"), clock="__time"),
    header("PlotJuggler", "seven", "__time",
           [n for k in range(1, 8) for n in (f"/joint_states/joint_{k}/effort",)],
           (Q7, numbered("/joint_states/joint_#/position", 1, 7)), clock="__time"),
    header("PlotJuggler", UR, "__time", wrench("/ft/raw/wrench/force/@", "/ft/raw/wrench/torque/@"),
           [*vector("/ft/filtered/wrench/force/@"), *vector("/ft/filtered/wrench/torque/@")], clock="__time"),
    header("PlotJuggler", UR, "__time", [*vector("/ft_a/wrench/force/@"), *vector("/ft_a/wrench/torque/@")],
           [*vector("/ft_b/wrench/force/@"), *vector("/ft_b/wrench/torque/@")], clock="__time", doubt="/ft_b"),
    header("PlotJuggler", WRIST, "__time", (PLACE, vector("/tcp/pose/position/@")),
           (("qx", "qy", "qz", "qw"), vector("/tcp/pose/orientation/@", "xyzw")),
           wrench("/ft/wrench/force/@", "/ft/wrench/torque/@"), clock="__time", orientation="quaternion"),
    header("Foxglove", UR, "time_ns", (Q6, numbered("/joint_states.position[#]", 0)),
           numbered("/joint_states.velocity[#]", 0), numbered("/joint_states.effort[#]", 0), clock="time_ns"),
    # sensors
    header("ATI Net F/T", UR, "Status (hex)", "RDT Sequence", "F/T Sequence", wrench("F@", "T@"), "Time",
           clock="Time"),
    header("ATI DAQ", WRIST, "time", numbered("G#", 0), clock="time"),
    header("ATI DAQ", WRIST, "time", numbered("SG#", 0), clock="time"),
    header("Robotiq", WRIST, "t", wrench("F@", "M@"), clock="t"),
    header("Bota", WRIST, "timestamp", wrench("F@ [N]", "M@ [Nm]"), (ACCELEROMETER, vector("A@ [m/s^2]")),
           vector("R@ [rad/s]"), "Temperature [°C]", clock="timestamp"),
    header("Kistler DynoWare", WRIST, "Time", ["Fx1+2", "Fx3+4", "Fy1+4", "Fy2+3", "Fz1", "Fz2", "Fz3", "Fz4"],
           clock="Time"),
    header("Schunk", WRIST, "Zeit", wrench("Kraft @", "Drehmoment @", "xyz"), clock="Zeit"),
    # measuring amplifiers
    header("catman", HEX, "Zeit  1 - Standardmessrate [s]", (STRUTS, numbered("Strut # [mm]")),
           (BAR_FORCES, numbered("Force # [N]")), "Trigger",
           clock="Zeit  1 - Standardmessrate [s]", trigger=("Trigger",)),
    header("catman", HEX, "Time  1 - default sample rate", (BAR_FORCES, numbered("MX840B_Kraft #")),
           clock="Time  1 - default sample rate"),
    header("catman", HEX, "Zeit  2 - Schnelle Messrate", (BAR_FORCES, numbered("Kraftaufnehmer # [kN]")),
           clock="Zeit  2 - Schnelle Messrate"),
    header("DIAdem", HEX, "Time", (STRUTS, numbered("Leg#")), (BAR_FORCES, numbered("LoadCell#")), "Gate",
           clock="Time", trigger=("Gate",)),
    header("DEWESoft", WRIST, "Time (s)", wrench("F@ (N)", "M@ (Nm)"), clock="Time (s)"),
    header("LabVIEW", HEX, "X_Value", (BAR_FORCES, numbered("Force_# (N)", 0)), "Comment", clock="X_Value"),
    header("LabVIEW", HEX, "X_Value", numbered("Voltage_#", 0), "Comment", clock="X_Value"),
    header("LabVIEW", HEX, "X_Value", numbered("cDAQ1Mod1/ai#", 0), "Comment", clock="X_Value"),
    header("imc", HEX, "Zeit [s]", numbered("Kanal_#_Temperatur"), (BAR_FORCES, numbered("Kraft_#")),
           clock="Zeit [s]"),
    header("HX711", HEX, "millis", (BAR_FORCES, numbered("LC#_raw")), clock="millis"),
    # controls
    header("TwinCAT Scope", HEX, (DRIVES, numbered("Axis #.ActPos")), numbered("Axis #.SetPos"),
           numbered("Axis #.PosDiff"), numbered("Axis #.ActVelo"), (BAR_FORCES, numbered("Force#")), "bTrigger"),
    header("TwinCAT Scope", HEX, (DRIVES, numbered("MAIN.fbAxis[#].NcToPlc.ActPos")),
           numbered("MAIN.fbAxis[#].NcToPlc.ActTorque"), (BAR_FORCES, numbered("MAIN.fForce[#]"))),
    header("TwinCAT Scope", HEX, numbered("Axis #.Enc.ActPos"), numbered("Axis #.NcToPlc.ActPos"), doubt="Enc"),
    header("SINUMERIK trace", HEX, "time", (DRIVES, numbered("/Nck/!SD/nckServoDataActPos1stEnc64 [u1, #]")),
           numbered("/Nck/!SD/nckServoDataActCurr64 [u1, #]"), numbered("/Nck/!SD/nckServoDataContDev64 [u1, #]"),
           numbered("/Channel/!RP/rpa [u1, #]", 21), "/Nck/!S/anAOut [u1, 1]",
           clock="time", trigger=("/Nck/!S/anAOut [u1, 1]",)),
    header("SINUMERIK trace", HEX, "time", (DRIVES, numbered("ActPos# [u1; #]")), clock="time"),
    header("SINUMERIK", TABLE, "Zeit", (TABLE_AXES, vector("$AA_IM[@]", "XYZAC")), vector("$AA_IW_SOLL[@]", "XYZAC"),
           clock="Zeit"),
    header("LinuxCNC halscope", HEX, "time", (DRIVES, numbered("joint.#.pos-fb", 0)), numbered("joint.#.pos-cmd", 0),
           numbered("joint.#.f-error", 0), numbered("joint.#.vel-cmd", 0), "motion.digital-out-00",
           clock="time", trigger=("motion.digital-out-00",)),
    header("LinuxCNC halscope", HEX, "time", (BAR_FORCES, numbered("loadcell-#", 0)), "motion.feed-override",
           clock="time", override=("motion.feed-override",)),
    header("HEIDENHAIN TNCscope", TABLE, "t", vector("s dif @", "XYZAC"), (TABLE_AXES, vector("s actual @", "XYZAC")),
           vector("v act. @", "XYZAC"), vector("i ist @", "XYZAC"), clock="t"),
    header("Aerotech", TABLE, "Time (ms)", (TABLE_AXES, vector("Position Feedback (@)", "XYZAC")),
           vector("Position Command (@)", "XYZAC"), vector("Position Error (@)", "XYZAC"), clock="Time (ms)"),
    header("five-axis logger", TABLE, "Time", (TABLE_AXES, [*"XYZAC"]), wrench("F@", "M@"), "Trigger",
           clock="Time", trigger=("Trigger",)),
    header("CODESYS trace", HEX, "Time", (DRIVES, numbered("PLC_PRG.Axis#.fActPosition")),
           numbered("PLC_PRG.Axis#.fSetPosition"), numbered("PLC_PRG.Axis#.fActVelocity"),
           (BAR_FORCES, numbered("PLC_PRG.rForce[#]")), clock="Time"),
    header("B&R trace", HEX, "t [ms]", (DRIVES, numbered("gAxis0#.ActualPosition")), numbered("gAxis0#.LagError"),
           clock="t [ms]"),
    header("dSPACE ControlDesk", HEX, "time", (STRUTS, numbered("Model Root/Legs/Leg#_length")),
           numbered("Model Root/Legs/Leg#_velocity"), (BAR_FORCES, numbered("Model Root/Sensors/Force#")),
           clock="time"),
    header("Simulink", WRIST, "time", (ROTATION, [f"R[{i}][{j}]" for i in range(1, 4) for j in range(1, 4)]),
           wrench("Force@", "Torque@", "XYZ"), clock="time", orientation="matrix"),
    # hexapods
    header("PI hexapod", HEX, "Time", ((*PLACE, *ANGLES), [*"XYZUVW"]), (BAR_FORCES, numbered("F#")), "Trigger",
           clock="Time", trigger=("Trigger",), orientation="xyz intrinsic"),
    header("hexapod, pose in words", HEX, "t", (PLACE, vector("pos_@")), (ANGLES, ["roll", "pitch", "yaw"]),
           (BAR_FORCES, numbered("Kraft #")), clock="t", orientation="xyz extrinsic"),
    header("German", HEX, "Zeitstempel", (STRUTS, numbered("Strebenlänge #")), numbered("Sollposition Strebe #"),
           (BAR_FORCES, numbered("Stabkraft #")), "Vorschub-Override", clock="Zeitstempel",
           override=("Vorschub-Override",)),
    header("ours", HEX, ((CLOCK, *STRUTS, *BAR_FORCES, TRIGGER, OVERRIDE),
           [CLOCK, *STRUTS, *BAR_FORCES, TRIGGER, OVERRIDE]), numbered("Force #"), "Time", clock=CLOCK),
    # FANUC and others
    header("FANUC", UR, "TIME", (Q6, numbered("J# [deg]")), wrench("F@", "M@"), clock="TIME"),
    header("FANUC", WRIST, "time", ((*PLACE, *ANGLES), [*"XYZWPR"]), wrench("F@", "T@"), clock="time",
           orientation="xyz extrinsic"),
    header("FANUC", WRIST, "time", vector("TCP_F@"), vector("TCP_M@"), clock="time", doubt="TCP_Fx"),
    header("compensated topic", UR, "__time", vector("/ft/compensated/force/@"), vector("/ft/compensated/torque/@"),
           clock="__time", doubt="compensated"),
    header("Doosan", UR, "timestamp", (Q6, numbered("actual_joint_position[#]", 0)),
           numbered("actual_joint_velocity[#]", 0), numbered("external_tcp_force[#]", 0),
           (WRENCH, numbered("raw_force_torque[#]", 0)), clock="timestamp", doubt="external_tcp_force"),
    # a sensor that somebody turns has no joints: angles need no position beside them
    header("angles alone", WRIST, (ANGLES, [*"ABC"]), wrench("F@", "T@"), orientation="zyx intrinsic"),
    header("angles alone, of a robot", UR, [*"ABC"], wrench("F@", "T@")),
    header("rotation vector alone", WRIST, (ANGLES, ["rx", "ry", "rz"]), orientation="rotation vector"),
    header("homogeneous matrix", WRIST, (ROTATION, [f"T{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]),
           ["T14", "T24", "T34", "T41", "T42", "T43", "T44"], orientation="matrix"),
    header("libfranka, by columns", WRIST, (("r11", "r21", "r31"), numbered("O_T_EE[#]", 0, 3)), ["O_T_EE[3]"],
           (("r12", "r22", "r32"), numbered("O_T_EE[#]", 4, 3)), ["O_T_EE[7]"],
           (("r13", "r23", "r33"), numbered("O_T_EE[#]", 8, 3)), numbered("O_T_EE[#]", 11, 5), orientation="matrix"),
    header("matrix by numbers", WRIST, (ROTATION, numbered("R[#]", 0, 9)), orientation="matrix"),
    header("16 numbers of something", WRIST, numbered("status[#]", 0, 16)),
    # units decide where words do not
    header("load bars by unit", HEX, "t", (BAR_FORCES, numbered("Messstab #, Zug positiv [N]")),
           numbered("Antrieb #: Strom [A]"), numbered("Position des Schlittens # [mm/s]"), clock="t"),
    header("joints by unit", UR, "t", (Q6, numbered("joint_# [rad]")), numbered("axis # [Nm]"), clock="t"),
    header("seven joints", UR, "t", numbered("q[#]", 0, 7), clock="t", doubt="7 joints"),
    header("no machine named", "none", "t", (STRUTS, numbered("leg #")), (BAR_FORCES, numbered("force #")), clock="t"),
]  # fmt: skip


@pytest.mark.parametrize("line", HEADERS, ids=lambda line: line.recorder)
def test_names_have_the_right_meaning_or_none(line: Header) -> None:
    said = meaning_of(line.names, machine(line.machine))
    assert {ours: line.names[k] for ours, k in said.places.items()} == line.right
    assert (line.names[said.clocks[0]] if said.clocks else None) == line.clock or line.clock is None
    for column, right in ((TRIGGER, line.trigger), (OVERRIDE, line.override)):
        found = tuple(line.names[k] for k in said.candidates.get(column, ()))
        assert found == right or not right
    assert said.orientations[:1] == (() if line.orientation is None else (line.orientation,))
    if line.doubt is not None:
        assert any(line.doubt in sentence for sentence in said.doubts), said.doubts


def test_the_table_is_of_many_recorders() -> None:
    assert len(HEADERS) >= 60
    assert len({line.recorder for line in HEADERS}) >= 15


def groups(right: dict[str, str]) -> list[set[str]]:
    """The columns of the right meaning in the groups that belong together."""
    together = (STRUTS, DRIVES, Q7, TABLE_AXES, PLACE, ANGLES, QUATERNION, ROTATION, ACCELEROMETER, BAR_FORCES, WRENCH)
    return [set(right) & {*group} for group in together if set(right) & {*group}]


@pytest.mark.parametrize("line", HEADERS, ids=lambda line: line.recorder)
def test_the_order_of_columns_does_not_matter(line: Header) -> None:
    right = meaning_of(line.names, machine(line.machine)).places
    turned = line.names[::-1]
    assert {ours: turned[k] for ours, k in meaning_of(turned, machine(line.machine)).places.items()} == {
        ours: line.names[k] for ours, k in right.items()
    }


@pytest.mark.first(25)
@pytest.mark.parametrize("line", HEADERS, ids=lambda line: line.recorder)
def test_without_a_column_its_group_has_no_meaning_and_is_not_filled_up_from_others(line: Header) -> None:
    case = machine(line.machine)
    for dropped in range(len(line.names)):
        names = line.names[:dropped] + line.names[dropped + 1 :]
        found = {ours: names[k] for ours, k in meaning_of(names, case).places.items()}
        for group in groups(line.right):
            kept = {found[ours] for ours in group if ours in found} & {line.right[ours] for ours in group}
            assert len(kept) in (0, len(group)), (line.names[dropped], found)  # all of another family, or none


@pytest.mark.parametrize("unit", ["N rms", "N_RMS", "V -> N", "N/V", "0..10 V = 0..5 kN"])
@pytest.mark.parametrize(
    ("on", "ours", "names"),
    [
        ("hexapod", BAR_FORCES, numbered("F#")),
        ("ft_wrist", WRENCH, [*vector("F@"), *vector("M@")]),
    ],
)
def test_forces_in_a_unit_that_nobody_knows_are_proposed_so_that_the_reader_names_it(
    on: str, ours: Sequence[str], names: list[str], unit: str
) -> None:
    meaning = meaning_of(["t_s", *(f"{name} [{unit}]" for name in names)], machine(on))
    assert {name: meaning.places[name] for name in ours} == {name: k for k, name in enumerate(ours, 1)}


def test_statistics_of_forces_are_not_taken_for_them_and_it_is_said() -> None:
    meaning = meaning_of(["t_s", *numbered("F# rms [N]")], machine("hexapod"))
    assert not {*BAR_FORCES} & {*meaning.places}
    (said,) = meaning.doubts
    assert "F1 rms [N]" in said
    assert "'rms'" in said
    assert "[recording.columns]" in said


POSITION = ("x_mm", "y_mm", "z_mm")


@pytest.mark.parametrize(
    ("ours", "names"),
    [
        (QUATERNION, ["qw", "qx", "qy", "qz"]),
        (ROTATION, [f"R{i}{j}" for i in "123" for j in "123"]),
        (ROTATION, [f"R{i}{j}" for i in "012" for j in "012"]),
        (ROTATION, numbered("R[#]", 0, 9)),
        (ANGLES, ["a_deg", "b_deg", "c_deg"]),
        (ANGLES, ["phi", "theta", "psi"]),
    ],
)
@pytest.mark.parametrize("place", [["X [mm]", "Y [mm]", "Z [mm]"], [*POSITION]])
def test_a_hexapods_pose_is_position_and_orientation_whatever_writes_them(
    ours: Sequence[str], names: list[str], place: list[str]
) -> None:
    meaning = meaning_of(["t_s", *place, *names, *numbered("f#_N")], machine("hexapod"))
    assert {name: meaning.places.get(name) for name in (*POSITION, *ours)} == {
        name: k for k, name in enumerate((*POSITION, *ours), 1)
    }


@pytest.mark.parametrize("first", [0, 1])
def test_a_homogeneous_matrix_holds_position_and_orientation(first: int) -> None:
    numbers = range(first, first + 4)
    meaning = meaning_of([f"T_{i}_{j}" for i in numbers for j in numbers], machine("hexapod"))
    assert [meaning.places[name] for name in POSITION] == [3, 7, 11]
    assert [meaning.places[name] for name in ROTATION] == [0, 1, 2, 4, 5, 6, 8, 9, 10]


def test_sixteen_numbers_of_a_matrix_have_no_order_and_it_is_said() -> None:
    meaning = meaning_of(numbered("T[#]", 0, 16), machine("hexapod"))
    assert not {*ROTATION} & {*meaning.places}
    assert any("T[0] .. T[15]" in said and "r11" in said for said in meaning.doubts)
