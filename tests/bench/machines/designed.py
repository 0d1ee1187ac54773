"""Twelve hexapods that differ in kind: what planners are measured on beside the paper's machine.

Geometries resemble machines that are sold; loads, sensors and limits are assumed. Boxes are strokes of single axes, as
makers state them, and not reachable as a whole, unless a title says otherwise.
"""

from tests.bench.machines.description import Hexapod

DESIGNED: dict[str, Hexapod] = {
    "small": Hexapod(
        title="Small platform, rings of 150 mm and 110 mm, with wide strokes of single axes",
        base=(150.0, 12.0), platform=(110.0, 48.0), home=(0.0, 0.0, 265.0, 0.0, 0.0, 0.0), struts=(235.0, 325.0),
        box=(100.0, 100.0, 40.0, 20.0, 20.0, 40.0),
        rates=(300.0, 60.0), accelerations=(3.0, 10.0), jerks=(60.0, 200.0), drives=(0.4, 4.0),
        frame=(60.0, 70.0, 48.0), range_N=200.0, mass=3.0, height=50.0, gyration=60.0,
    ),
    "desktop": Hexapod(
        title="Desktop positioner of 100 mm strokes on a 2 ms cycle, with two weights",
        base=(170.0, 10.0), platform=(110.0, 50.0), home=(0.0, 0.0, 255.0, 0.0, 0.0, 0.0), struts=(240.0, 320.0),
        box=(50.0, 50.0, 30.0, 20.0, 20.0, 30.0),
        rates=(200.0, 50.0), accelerations=(4.0, 12.0), jerks=(80.0, 250.0), drives=(0.3, 5.0),
        frame=(55.0, 65.0, 45.0), range_N=500.0, mass=5.0, height=60.0, gyration=65.0, payloads=(2.0, 2.0),
        cycle_ms=2.0,
    ),
    "slow": Hexapod(
        title="Slow positioning hexapod, 50 mm/s, whole box within reach",
        base=(280.0, 10.0), platform=(190.0, 50.0), home=(0.0, 0.0, 325.0, 0.0, 0.0, 0.0), struts=(310.0, 435.0),
        box=(25.0, 25.0, 15.0, 5.0, 5.0, 6.0),
        rates=(50.0, 12.0), accelerations=(0.5, 2.0), jerks=(10.0, 40.0), drives=(0.06, 0.6),
        frame=(100.0, 118.0, 80.0), range_N=2000.0, mass=40.0, height=120.0, gyration=130.0, cutoff=20.0,
    ),
    "platform": Hexapod(
        title="Motion platform of 1.8 m to 3 m struts for a tonne, 0.6 m/s",
        base=(1600.0, 8.0), platform=(1350.0, 52.0), home=(0.0, 0.0, 2100.0, 0.0, 0.0, 0.0), struts=(1800.0, 3000.0),
        box=((-800.0, 900.0), 850.0, 500.0, 22.0, 22.0, 25.0),
        rates=(600.0, 30.0), accelerations=(5.0, 4.0), jerks=(60.0, 60.0), drives=(0.8, 7.0),
        frame=(700.0, 820.0, 560.0), range_N=20000.0, mass=1000.0, height=700.0, gyration=800.0, payloads=(300.0,),
        cutoff=25.0,
    ),
    "simulator": Hexapod(
        title="Motion platform of 1 m to 1.6 m struts, 0.5 m/s, slow to turn",
        base=(900.0, 10.0), platform=(750.0, 50.0), home=(0.0, 0.0, 1160.0, 0.0, 0.0, 0.0), struts=(1000.0, 1600.0),
        box=((-400.0, 450.0), 400.0, 260.0, 21.0, 22.0, 24.0),
        rates=(500.0, 20.0), accelerations=(5.0, 3.0), jerks=(80.0, 60.0), drives=(0.6, 6.0),
        frame=(400.0, 470.0, 320.0), range_N=8000.0, mass=300.0, height=400.0, gyration=450.0,
    ),
    "flat": Hexapod(
        title="Flat hexapod: struts at 50 degrees, whose joints open to 68 degrees",
        base=(500.0, 10.0), platform=(400.0, 50.0), home=(0.0, 0.0, 265.0, 0.0, 0.0, 0.0), struts=(330.0, 510.0),
        box=(90.0, 90.0, (-70.0, 80.0), 15.0, 15.0, 14.0),
        rates=(400.0, 60.0), accelerations=(6.0, 12.0), jerks=(100.0, 250.0), drives=(0.5, 6.0), joints=(68.0, 68.0),
        frame=(200.0, 234.0, 160.0), range_N=3000.0, mass=40.0, height=100.0, gyration=150.0,
    ),
    "tall": Hexapod(
        title="Tall hexapod on a narrow base, nearly parallel struts, whole box within reach",
        base=(200.0, 12.0), platform=(120.0, 46.0), home=(0.0, 0.0, 700.0, 0.0, 0.0, 0.0), struts=(575.0, 845.0),
        box=(90.0, 90.0, 50.0, 15.0, 15.0, 20.0),
        rates=(400.0, 60.0), accelerations=(5.0, 10.0), jerks=(90.0, 200.0), drives=(0.6, 6.0),
        frame=(70.0, 82.0, 58.0), range_N=800.0, mass=8.0, height=80.0, gyration=80.0, payloads=(3.0,),
    ),
    "offset": Hexapod(
        title="Home off centre and tilted, limits of the box uneven",
        base=(450.0, 12.0), platform=(260.0, 48.0), home=(90.0, -60.0, 560.0, 6.0, -8.0, 15.0), struts=(480.0, 760.0),
        box=((-250.0, 90.0), (-100.0, 200.0), (-60.0, 70.0), (-20.0, 15.0), (-15.0, 28.0), (-30.0, 20.0)),
        rates=(500.0, 60.0), accelerations=(5.0, 10.0), jerks=(90.0, 200.0), drives=(0.7, 7.0),
        frame=(130.0, 152.0, 105.0), range_N=2000.0, mass=20.0, height=90.0, gyration=110.0,
    ),
    "mill": Hexapod(
        title="Machining hexapod below the ceiling with spindle, table and fixture; its struts reach the whole box",
        base=(600.0, 10.0), platform=(260.0, 50.0), home=(0.0, 0.0, 720.0, 0.0, 0.0, 0.0), struts=(550.0, 1180.0),
        box=(140.0, 140.0, 115.0, 14.0, 14.0, 20.0),
        rates=(600.0, 50.0), accelerations=(6.0, 8.0), jerks=(100.0, 160.0), drives=(0.9, 9.0), hangs=True,
        frame=(140.0, 164.0, 112.0), range_N=5000.0, mass=45.0, height=120.0, gyration=120.0,
        keep_out=(
            ("table", ((-500.0, 500.0), (-500.0, 500.0), (1090.0, 1200.0))),
            ("fixture", ((70.0, 300.0), (-150.0, 150.0), (970.0, 1090.0))),
        ),
        tools=(("spindle", (0.0, 0.0, 220.0), 35.0),),
    ),
    "drives": Hexapod(
        title="Weak drives: struts of 0.25 m/s below a platform that may move at 0.6 m/s",
        base=(500.0, 12.0), platform=(250.0, 48.0), home=(0.0, 0.0, 630.0, 0.0, 0.0, 0.0), struts=(560.0, 860.0),
        box=(200.0, 200.0, 130.0, 20.0, 20.0, 25.0),
        rates=(600.0, 60.0), accelerations=(6.0, 10.0), jerks=(100.0, 200.0), drives=(0.25, 3.0),
        frame=(130.0, 152.0, 105.0), range_N=3000.0, mass=25.0, height=100.0, gyration=110.0,
    ),
    "sensors": Hexapod(
        title="Sensors whose range the last of three weights nearly takes, whole box within reach",
        base=(400.0, 12.0), platform=(220.0, 48.0), home=(0.0, 0.0, 475.0, 0.0, 0.0, 0.0), struts=(380.0, 720.0),
        box=(75.0, 75.0, 45.0, 12.0, 12.0, 14.0),
        rates=(500.0, 60.0), accelerations=(6.0, 12.0), jerks=(100.0, 240.0), drives=(0.8, 8.0),
        frame=(110.0, 129.0, 90.0), range_N=300.0, mass=15.0, height=80.0, gyration=100.0, payloads=(6.0, 6.0, 6.0),
    ),
    "wrist": Hexapod(
        title="Six-axis force/torque sensor between platform and load instead of bars",
        base=(250.0, 12.0), platform=(150.0, 48.0), home=(0.0, 0.0, 395.0, 0.0, 0.0, 0.0), struts=(340.0, 510.0),
        box=(110.0, 110.0, 70.0, 24.0, 24.0, 35.0),
        rates=(400.0, 80.0), accelerations=(5.0, 15.0), jerks=(100.0, 300.0), drives=(0.6, 8.0),
        frame=None, range_N=200.0, mass=4.0, height=60.0, gyration=60.0, cycle_ms=4.0,
    ),
}  # fmt: skip
