"""Chains that many tests share: a planar arm, one with slides and odd axes."""

from cases.chain import Chain


def joint(name: str, kind: str = "revolute", **keys: object) -> dict[str, object]:
    """A joint of a case file, with a wide range and home at 0 where nothing else is said."""
    unit = "mm" if kind == "prismatic" else "deg"
    ends = {} if kind == "continuous" else {f"position_{unit}": (-900.0, 900.0)}
    return {"name": name, "kind": kind, "axis": (0.0, 0.0, 1.0), f"home_{unit}": 0.0} | ends | keys


def chain(*joints: dict[str, object], **sensor: object) -> Chain:
    """A chain of such joints; `sensor` has the keys of its mount."""
    return Chain.model_validate({"joints": joints, "sensor": sensor})


def planar(first: float, second: float) -> Chain:
    """Two links in the plane x, y, of some lengths [mm]."""
    return chain(joint("one"), joint("two", origin_mm=(first, 0.0, 0.0)), origin_mm=(second, 0.0, 0.0))


def odd() -> Chain:
    """Seven joints with axes in all directions, two of which slide, and a sensor that is mounted askew."""
    return chain(
        joint("a", origin_mm=(0.0, 0.0, 180.7)),
        joint("b", "prismatic", origin_mm=(10.0, -40.0, 25.0), rpy_deg=(20.0, -35.0, 100.0), axis=(0.0, 3.0, 4.0)),
        joint("c", "continuous", origin_mm=(0.0, 120.0, 0.0), rpy_deg=(90.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0)),
        joint("d", rpy_deg=(0.0, 90.0, 0.0), origin_mm=(612.7, 0.0, 0.0), axis=(1.0, -2.0, 0.5)),
        joint("e", "prismatic", origin_mm=(0.0, 0.0, 99.0), axis=(-1.0, 0.0, 0.0)),
        joint("f", origin_mm=(0.0, 300.0, 0.0), rpy_deg=(0.0, 0.0, 180.0), axis=(0.0, 0.0, -2.0)),
        joint("g", origin_mm=(5.0, 6.0, 7.0), rpy_deg=(-50.0, 10.0, 5.0), axis=(0.0, 1.0, 0.0)),
        origin_mm=(3.0, -8.0, 45.0),
        rpy_deg=(180.0, 15.0, -70.0),
    )
