"""Import of CASPR models: cable robots of one rigid link from the XML files of the MATLAB platform CASPR.

A model is two files in one folder, ``NAME_bodies.xml`` and ``NAME_cables.xml``; the format is that of CASPR's templates
and reader (https://github.com/darwinlau/CASPR, ``data/model_config/templates``). Read are one ``link_rigid`` on a
``PLANAR_XY`` or ``SPATIAL_EULER_XYZ`` joint to the world, and of a ``cable_set`` (the default one unless named)
``cable_ideal`` and ``cable_linear_spring`` between the world (link 0) and the link (link 1), with an ``attachment`` or
a ``base_rotating_pulley`` in the world. Everything else that would change the answer is refused, the element named.

Conventions of the format: ``attachment_reference="com"`` counts the link's points from its centre of mass, ``"joint"``
from the link's frame; ``inertia ref`` likewise; ``K`` (or ``K_cable``) is the stiffness of a unit length, EA; products
of inertia are entries of the matrix, without a change of sign. The platform frame here is the link's frame, so CASPR's
joint variables are the pose less the joint's ``location`` in the world. Out-of-plane coordinates of planar models must
agree at both ends of each cable.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from xml.parsers import expat
from xml.parsers.expat import ExpatError

import msgspec

from steeplejack.errors import InputError
from steeplejack.files import read_source, shortened
from steeplejack.robots.cable_robot.parameters import Dimension, Parameters
from steeplejack.robots.cable_robot.robot import CableRobot

Vector = tuple[float, float, float]

JOINTS: dict[str, Dimension] = {"PLANAR_XY": "planar", "SPATIAL_EULER_XYZ": "spatial"}
CABLES = ("cable_ideal", "cable_linear_spring")
OUT_OF_PLANE = 1e-9  # [1] of the largest coordinate, up to which a cable of a planar model lies in a plane


def load_caspr(folder: str | Path, cable_set: str | None = None) -> CableRobot:
    """Read a CASPR model.

    Args:
        folder: Folder with one ``*_bodies.xml`` and one ``*_cables.xml``, or the path of either file.
        cable_set: Which ``cable_set`` by its id; the model's default one by default.

    Returns:
        The robot, SI, named after the model.

    Raises:
        InputError: No such model, or an element that is missing, malformed or not supported; the message names it.
    """
    bodies_file, cables_file = _files(folder)
    name = bodies_file.name.removesuffix("_bodies.xml")
    link = _read_link(_Node.root(bodies_file, "bodies_system"))
    cables, pulleys = _read_cables(_Node.root(cables_file, "cables"), cable_set, link)
    tables = {"platform": link.table, "cables": cables} | ({"pulleys": pulleys} if pulleys else {})
    for table in tables.values():
        table["source"] = dict.fromkeys(table, f"CASPR model {name}")
    text = f"CASPR model {name}, set {cable_set or 'default'}"
    try:
        parameters = msgspec.convert(
            {"name": name, "description": text, "dimension": link.dimension, **tables}, type=Parameters
        )
    except msgspec.ValidationError as error:
        raise InputError(str(cables_file.parent), str(error), "a model of one rigid link") from None
    return CableRobot.of(parameters)


@dataclass(frozen=True)
class _Node:
    """An element with the file it stands in, so that every complaint can name both."""

    file: Path
    element: Element

    @classmethod
    def root(cls, file: Path, tag: str) -> _Node:
        content = read_source(file, "a CASPR model file")
        try:
            _refuse_entities(file, content)
            element = ElementTree.fromstring(content)
        except (ElementTree.ParseError, ExpatError, LookupError, ValueError, RecursionError) as error:
            raise InputError(str(file), f"not XML: {shortened(str(error))}", "a CASPR model file") from None
        node = cls(file, element)
        if element.tag != tag:
            node.refuse(f"<{element.tag}>", f"<{tag}> at the top")
        return node

    def refuse(self, what: str, valid: str) -> NoReturn:
        """Raise an `InputError` about this element."""
        label = self.element.get("name") or self.element.get("id") or self.element.get("num")
        named = f" {shortened(label)!r}" if label else ""
        where = f"{self.file.name}, <{shortened(self.element.tag)}>{named}"
        raise InputError(where, shortened(what), valid)

    def children(self) -> list[_Node]:
        return [_Node(self.file, child) for child in self.element]

    def child(self, tag: str) -> _Node:
        """The only child of that name."""
        found = self.element.findall(tag)
        if len(found) != 1:
            self.refuse(f"{len(found)} elements <{tag}>", "exactly one")
        return _Node(self.file, found[0])

    def attribute(self, name: str, valid: tuple[str, ...]) -> str:
        value = self.element.get(name)
        if value not in valid:
            self.refuse(f"{name}={value!r}", f"{name} as one of {', '.join(valid)}")
        return value

    def numbers(self, count: int) -> tuple[float, ...]:
        words = (self.element.text or "").split()
        try:
            values = tuple(float(word) for word in words if "_" not in word)  # Python's own 1_000 is no XML number
        except ValueError:
            values = ()
        if len(values) != count or not all(map(math.isfinite, values)):
            self.refuse(repr(" ".join(words)), f"{count} finite number{'s' if count > 1 else ''}")
        return values

    def number(self) -> float:
        return self.numbers(1)[0]

    def vector(self) -> Vector:
        x, y, z = self.numbers(3)
        return x, y, z


@dataclass(frozen=True)
class _Link:
    """The rigid link: its values as in a robot file, and what its cables' coordinates count from."""

    dimension: Dimension
    table: dict[str, object]
    centre: Vector
    height: float


def _refuse_entities(file: Path, content: bytes) -> None:
    """Refuse a file that defines entities of its own: no model needs them, and a few lines of them fill a memory."""

    def refuse(name: str, *_declared: object) -> NoReturn:
        raise InputError(str(file), f"defines the entity {shortened(name)!r}", "a model without entities")

    parser = expat.ParserCreate()
    parser.EntityDeclHandler = refuse
    parser.Parse(content, True)


def _files(folder: str | Path) -> tuple[Path, Path]:
    """The two files of a model."""
    valid = "the folder of one CASPR model"
    try:
        path = Path(folder)
        if path.is_file():
            stem = path.name.removesuffix("_bodies.xml").removesuffix("_cables.xml")
            return path.with_name(f"{stem}_bodies.xml"), path.with_name(f"{stem}_cables.xml")
        found = sorted(path.glob("*_bodies.xml"))
    except OSError as error:
        raise InputError(shortened(str(folder)), error.strerror or "cannot be read", valid) from None
    except (TypeError, ValueError) as error:  # no path at all, or one with a NUL in it
        raise InputError(repr(folder), shortened(str(error)), valid) from None
    if len(found) != 1:
        raise InputError(str(path), f"{len(found)} files *_bodies.xml", valid)
    return found[0], found[0].with_name(found[0].name.removesuffix("_bodies.xml") + "_cables.xml")


def _read_link(system: _Node) -> _Link:
    links = system.child("links")
    if len(links.children()) != 1:
        links.refuse(f"{len(links.children())} links", "a robot with one rigid link")
    link = links.child("link_rigid")
    dimension = JOINTS[link.child("joint").attribute("type", tuple(JOINTS))]
    parent = link.child("parent")
    if parent.child("num").number() != 0:
        parent.refuse("a parent other than the world", "<num>0</num>")
    physical = link.child("physical")
    centre = physical.child("com_location").vector()
    mass = physical.child("mass").number()
    inertia = _read_inertia(physical.child("inertia"), mass, centre)
    axes = 2 if dimension == "planar" else 3
    table: dict[str, object] = {
        "mass": mass,
        "inertia": inertia[2][2] if dimension == "planar" else inertia,
        "centre_of_mass": centre[:axes],
    }
    return _Link(dimension, table, centre, parent.child("location").vector()[2])


def _read_inertia(node: _Node, mass: float, centre: Vector) -> tuple[Vector, Vector, Vector]:
    """Inertia about the centre of mass (parallel axes where it is given about the joint)."""
    xx, yy, zz, xy, xz, yz = (node.child(f"I{axes}").number() for axes in ("xx", "yy", "zz", "xy", "xz", "yz"))
    if node.attribute("ref", ("com", "joint")) == "joint":
        x, y, z = centre
        xx, yy, zz = xx - mass * (y * y + z * z), yy - mass * (x * x + z * z), zz - mass * (x * x + y * y)
        xy, xz, yz = xy + mass * x * y, xz + mass * x * z, yz + mass * y * z
    return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)


def _read_cables(root: _Node, name: str | None, link: _Link) -> tuple[dict[str, object], dict[str, object]]:
    """The tables ``cables`` and ``pulleys`` of a robot file; the second empty where there is no pulley."""
    wanted = name if name is not None else root.element.get("default_cable_set")
    sets = [node for node in root.children() if node.element.get("id") == wanted]
    if len(sets) != 1:
        known = ", ".join(str(node.element.get("id")) for node in root.children())
        root.refuse(f"{len(sets)} sets with id {wanted!r}", f"one of {known or 'at least one set'}")
    cables = [_read_cable(node, link) for node in sets[0].children()]
    if not cables:
        sets[0].refuse("no cables", "at least one")
    table: dict[str, object] = {
        "anchors": tuple(cable.anchor for cable in cables),
        "attachments": tuple(cable.attachment for cable in cables),
        "tension_min": tuple(cable.window[0] for cable in cables),
        "tension_max": tuple(cable.window[1] for cable in cables),
    }
    stiffness = tuple(cable.axial_stiffness for cable in cables if cable.axial_stiffness is not None)
    if stiffness and len(stiffness) != len(cables):
        sets[0].refuse("cables with and without stiffness", "all of one kind")
    if stiffness:
        table["axial_stiffness"] = stiffness
    if not any(cable.radius for cable in cables):
        return table, {}
    return table, {"radius": tuple(c.radius for c in cables), "axis": tuple(c.axis for c in cables)}


@dataclass(frozen=True)
class _Cable:
    """One cable, in the link's frame and in as many coordinates as the robot has."""

    anchor: tuple[float, ...]
    attachment: tuple[float, ...]
    window: tuple[float, float]
    axial_stiffness: float | None
    radius: float
    axis: tuple[float, ...]


def _read_cable(node: _Node, link: _Link) -> _Cable:
    if node.element.tag not in CABLES:
        node.refuse("this type of cable", f"one of {', '.join(CABLES)}")
    points = node.child("attachments").children()
    if len(points) != 2:
        node.refuse(f"{len(points)} attachments", "two: one in the world, one on the link")
    anchor, radius, axis = _read_anchor(points[0])
    end = points[1]
    if end.element.tag != "attachment" or end.child("link").number() != 1:
        end.refuse("the second end is not on the link", "<attachment> with <link>1</link>")
    offset = link.centre if node.attribute("attachment_reference", ("joint", "com")) == "com" else (0.0, 0.0, 0.0)
    x, y, z = (a + b for a, b in zip(end.child("location").vector(), offset, strict=True))
    properties = node.child("properties")
    axes = 2 if link.dimension == "planar" else 3
    if link.dimension == "planar":
        size = max(map(abs, (*anchor, x, y, z, link.height)))
        if abs(anchor[2] - link.height - z) > OUT_OF_PLANE * size or axis[2] != 0.0:
            node.refuse("leaves the plane of a planar robot", "both ends, and the pulley's axis, parallel to x and y")
    return _Cable(
        anchor=anchor[:axes],
        attachment=(x, y, z)[:axes],
        window=(properties.child("force_min").number(), properties.child("force_max").number()),
        axial_stiffness=_read_stiffness(properties) if node.element.tag == "cable_linear_spring" else None,
        radius=radius,
        axis=axis[:axes],
    )


def _read_anchor(point: _Node) -> tuple[Vector, float, Vector]:
    """Where a cable leaves the world, the radius of its pulley and the way it travels there."""
    if point.element.tag == "attachment":
        if point.child("link").number() != 0:
            point.refuse("the first end is not in the world", "<link>0</link>")
        return point.child("location").vector(), 0.0, (1.0, 0.0, 0.0)
    if point.element.tag != "base_rotating_pulley":
        point.refuse("this type of attachment", "<attachment> or <base_rotating_pulley>")
    entry = point.child("cable_entry_vector")
    axis = entry.vector()
    if math.hypot(*axis) == 0.0:
        entry.refuse("a direction without length", "the way the cable enters the pulley")
    return point.child("fixed_location").vector(), point.child("pulley_radius").number(), axis


def _read_stiffness(properties: _Node) -> float:
    """EA: CASPR's reader looks for ``K``, its files also say ``K_cable``."""
    tags = [tag for tag in ("K", "K_cable") if properties.element.find(tag) is not None]
    if len(tags) != 1:
        properties.refuse(f"{len(tags)} elements <K> or <K_cable>", "exactly one")
    return properties.child(tags[0]).number()
