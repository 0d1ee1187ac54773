"""The calibrated model as JSON: everything that an implementation of its own needs, versioned and described.

`calibration.schema.json` beside this file is the JSON Schema of `Document`. SI units and radians throughout.
"""

from importlib.metadata import version
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from postprocessors.export.calibration import Calibration

SCHEMA_VERSION = 1

Six = Annotated[list[float], Field(min_length=6, max_length=6)]
Three = Annotated[list[float], Field(min_length=3, max_length=3)]


class _Exported(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class _Versioned(_Exported):
    schema_version: Literal[1]
    kind: Literal["hexcite calibration"]


class Origin(_Exported):
    """What made the file, and from what."""

    hexcite: str = Field(description="version of hexcite")
    result: str = Field(description="file of the result")
    result_sha256: str = Field(description="first 16 digits of its hash")
    recording: str = Field(description="run that it was identified from")
    samples: int = Field(description="samples of that run that were used")
    s0: float = Field(description="(27): dimensionless with weights per channel, else N")
    case: str = Field(description="name of the case")
    case_hash: str = Field(description="fingerprint of the case")


class ExportedParameter(_Exported):
    """An identified value."""

    name: str
    unit: str = Field(description="SI")
    value: float
    std: float = Field(description="standard deviation by (28)")
    std_robust: float = Field(description="standard deviation that allows for noise that is not white")


class ExportedDrives(_Exported):
    """Struts from drive positions: strut k = sign[k] * position of drive[k] + offset[k]; drives counted from 1."""

    drive: list[int]
    sign: Six
    offset_m: Six


class ExportedKinematics(_Exported):
    """The hexapod: strut k joins base joint k (in {B}) to platform joint k (in {P})."""

    base_m: Annotated[list[Three], Field(min_length=6, max_length=6)]
    platform_m: Annotated[list[Three], Field(min_length=6, max_length=6)]
    home: Six = Field(description="x, y, z [m], roll, pitch, yaw [rad] of {P} in {B}")
    drives: ExportedDrives | None


class ExportedStruts(_Exported):
    """Sensors in the struts of `kinematics`: J^-T has the columns (R^T n_k; p_k x R^T n_k).

    n_k points from base joint k to platform joint k and has the length 1, p_k is platform joint k in {P}. What rods and
    tubes add stands in `linear`, as the page on where sensors sit of hexcite's documents describes.
    """

    at: Literal["drive", "platform"] = Field(description="end of the strut at which the sensor sits")


class Document(_Versioned):
    """A calibrated measurement model: external = -structure (forces - A(pose, twist, twist rate) u), (1)-(22).

    A has one column for each entry of `linear`. `external` acts on the platform, at the origin of {P}, along its axes.
    """

    origin: Origin
    warnings: list[str] = Field(description="of the identification; not empty only if the export was forced")
    model: int = Field(ge=0, le=9, description="identification model, Table 2")
    error_terms: list[str] = Field(description="forms of the error compensation, (12) to (15), in place of the model's")
    gravity_m_s2: Three = Field(description="in {B}")
    structure: Annotated[list[Six], Field(min_length=6, max_length=6)] | None = Field(
        description="J^-T of (2), row by row: sensor forces to force [N] and moment [N m] on the platform, in {P}; "
        "null where the sensors sit in the struts, for there it depends on the pose"
    )
    struts: ExportedStruts | None = Field(default=None, description="null where the sensors sit elsewhere")
    force_delay_s: float = Field(description="how much later than the motion the forces were recorded")
    kinematics: ExportedKinematics | None = Field(description="null for a sensor without a hexapod")
    linear: list[ExportedParameter] = Field(description="u of (17)")
    covariance: list[list[float]] = Field(description="of u by (28), in the same order")
    covariance_robust: list[list[float]] = Field(description="the same, allowing for noise that is not white")
    physical: list[ExportedParameter] = Field(
        description="mass, centre of gravity in {P}, inertia about it, offsets, factors"
    )


def document(calibration: Calibration) -> Document:
    """Everything that a calibration holds."""
    case, result = calibration.case, calibration.result
    struts = calibration.model.struts
    kinematics = None
    if case.hexapod is not None:
        drives = case.recording.drives
        kinematics = ExportedKinematics(
            base_m=case.hexapod.base.points.tolist(),
            platform_m=case.hexapod.platform.points.tolist(),
            home=case.hexapod.home.vector.tolist(),
            drives=drives
            and ExportedDrives(drive=list(drives.order), sign=list(drives.sign), offset_m=drives.offset.tolist()),
        )
    deviations = [np.sqrt(np.maximum(c.diagonal(), 0.0)) for c in (result.covariance, result.covariance_robust)]
    return Document(
        schema_version=1,
        kind="hexcite calibration",
        origin=Origin(
            hexcite=version("hexcite"),
            result=result.source,
            result_sha256=calibration.result_hash,
            recording=calibration.recording,
            samples=calibration.samples,
            s0=calibration.s0,
            case=case.name,
            case_hash=case.hash,
        ),
        warnings=list(calibration.warnings),
        model=calibration.model.number,
        error_terms=list(result.terms),
        gravity_m_s2=case.gravity.tolist(),
        structure=calibration.model.structure.tolist() if struts is None else None,
        struts=struts and ExportedStruts(at=struts.sensors.at),
        force_delay_s=result.delay,
        kinematics=kinematics,
        linear=[
            ExportedParameter(name=p.name, unit=p.unit, value=float(v), std=float(s), std_robust=float(r))
            for p, v, s, r in zip(calibration.model.parameters, result.values, *deviations, strict=True)
        ],
        covariance=result.covariance.tolist(),
        covariance_robust=result.covariance_robust.tolist(),
        physical=[
            ExportedParameter(name=name, unit=v.unit, value=v.value, std=v.std, std_robust=v.std_robust)
            for name, v in calibration.physical.items()
        ],
    )


def json_document(calibration: Calibration) -> str:
    """The text of the file."""
    return document(calibration).model_dump_json(indent=2) + "\n"
