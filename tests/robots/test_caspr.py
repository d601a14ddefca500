"""CASPR import: models written for these tests in the documented format, and every refusal by the element's name."""

from __future__ import annotations

import numpy as np
import pytest

from steeplejack.errors import InputError
from steeplejack.robots.cable_robot import load_caspr

BODIES = """<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE bodies_system SYSTEM "../bodies.dtd">
<bodies_system>
  <links display_range="0 4 0 3 -1 1" view_angle="0 90">
    <link_rigid num="1" name="plate">
      <joint type="{joint}" q_initial="0" q_min="0" q_max="1"/>
      <physical>
        <mass>3.5</mass>
        <com_location>0.02 -0.01 0.0</com_location>
        <end_location>0 0 0</end_location>
        <inertia ref="com">
          <Ixx>0.2</Ixx><Iyy>0.3</Iyy><Izz>0.4</Izz><Ixy>0.01</Ixy><Ixz>-0.02</Ixz><Iyz>0.03</Iyz>
        </inertia>
      </physical>
      <parent><num>0</num><location>0.1 0.2 {height}</location></parent>
    </link_rigid>
  </links>
</bodies_system>
"""
LAUGHS = """<?xml version="1.0"?>
<!DOCTYPE bodies_system [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;">]>
<bodies_system>&c;</bodies_system>
"""
PLANAR_ENDS = (("0 0 0", "-0.1 0 0"), ("4 0 0", "0.1 0 0"), ("4 3 0", "0.1 0.2 0"), ("0 3 0", "-0.1 0.2 0"))
SPATIAL_ENDS = (("0 0 2", "-0.1 0 0.1"), ("4 0 2", "0.1 0 -0.1"), ("4 3 2.5", "0.1 0.2 0"))


def cable(index, ends, reference="joint", tag="cable_ideal", extra=""):
    anchor, end = ends
    return f"""<{tag} name="cable {index}" attachment_reference="{reference}">
      <properties>{extra}<force_min>{index}</force_min><force_max>{100 + index}</force_max></properties>
      <attachments>
        <attachment><link>0</link><location>{anchor}</location></attachment>
        <attachment><link>1</link><location>{end}</location></attachment>
      </attachments></{tag}>"""


def cables(ends, **options):
    each = "\n".join(cable(i + 1, e, **options) for i, e in enumerate(ends))
    return f'<?xml version="1.0"?>\n<cables default_cable_set="one"><cable_set id="one">{each}</cable_set></cables>'


@pytest.fixture
def model(tmp_path):
    """Write a model and return its folder."""

    def write(bodies, cable_file):
        (tmp_path / "Plate_bodies.xml").write_text(bodies)
        (tmp_path / "Plate_cables.xml").write_text(cable_file)
        return tmp_path

    return write


@pytest.fixture
def planar(model):
    """A planar model with one text replaced by another in either file."""

    def write(old="", new="", **options):
        texts = BODIES.format(joint="PLANAR_XY", height=0), cables(PLANAR_ENDS, **options)
        assert old in "".join(texts)
        return model(*(text.replace(old, new, 1) if old else text for text in texts))

    return write


def test_a_planar_model(planar):
    robot = load_caspr(planar())
    assert (robot.name, robot.dimension) == ("Plate", "planar")
    np.testing.assert_array_equal(robot.anchors, [[0, 0], [4, 0], [4, 3], [0, 3]])
    np.testing.assert_array_equal(robot.attachments, [[-0.1, 0], [0.1, 0], [0.1, 0.2], [-0.1, 0.2]])
    np.testing.assert_array_equal(robot.lower, [1, 2, 3, 4])
    np.testing.assert_array_equal(robot.upper, [101, 102, 103, 104])
    assert (robot.mass, float(robot.inertia)) == (3.5, 0.4)
    np.testing.assert_array_equal(robot.centre_of_mass, [0.02, -0.01])
    assert robot.axial_stiffness is None
    assert robot.pulley_radii is None


def test_a_spatial_model(model):
    robot = load_caspr(model(BODIES.format(joint="SPATIAL_EULER_XYZ", height=0.7), cables(SPATIAL_ENDS)))
    assert robot.dimension == "spatial"
    np.testing.assert_array_equal(robot.inertia, [[0.2, 0.01, -0.02], [0.01, 0.3, 0.03], [-0.02, 0.03, 0.4]])
    np.testing.assert_array_equal(robot.anchors[2], [4, 3, 2.5])
    np.testing.assert_array_equal(robot.attachments[1], [0.1, 0, -0.1])


def test_attachments_from_the_centre_of_mass_are_moved_to_the_frame(planar):
    robot = load_caspr(planar(reference="com"))
    np.testing.assert_allclose(robot.attachments[2], [0.12, 0.19])
    np.testing.assert_array_equal(robot.anchors[2], [4, 3])


def test_inertia_about_the_joint_is_moved_to_the_centre_of_mass(model, rng):
    """The same body given about either point is one body."""
    mass, centre, root = 3.5, np.array([0.02, -0.01, 0.0]), rng.normal(size=(3, 3))
    about_centre = root @ root.T
    about_joint = about_centre + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    bodies = BODIES.format(joint="SPATIAL_EULER_XYZ", height=0).replace('ref="com"', 'ref="joint"')
    for name, (i, j), old in zip(
        ("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"),
        ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)),
        ("0.2", "0.3", "0.4", "0.01", "-0.02", "0.03"),
        strict=True,
    ):
        bodies = bodies.replace(f"<{name}>{old}<", f"<{name}>{float(about_joint[i, j])!r}<")
    robot = load_caspr(model(bodies, cables(SPATIAL_ENDS)))
    np.testing.assert_allclose(robot.inertia, about_centre, rtol=1e-12)


@pytest.mark.parametrize("tag", ("K", "K_cable"))
def test_springs_give_the_axial_stiffness(planar, tag):
    robot = load_caspr(planar(tag="cable_linear_spring", extra=f"<{tag}>2.5e4</{tag}>"))
    np.testing.assert_array_equal(robot.axial_stiffness, 2.5e4)
    stiffness = robot.stiffness(np.full(4, 20.0), [0.0, -9.81], [2.0, 1.5, 0.05])
    assert np.linalg.eigvalsh(stiffness)[0] > 0.0


def test_rotating_pulleys(planar):
    pulley = (
        "<base_rotating_pulley><fixed_location>0 0 0</fixed_location><pulley_radius>0.04</pulley_radius>"
        "<cable_entry_vector>0 2 0</cable_entry_vector></base_rotating_pulley>"
    )
    robot = load_caspr(planar("<attachment><link>0</link><location>0 0 0</location></attachment>", pulley))
    np.testing.assert_array_equal(robot.pulley_radii, [0.04, 0, 0, 0])
    np.testing.assert_array_equal(robot.pulley_axes[0], [0, 2])
    pose = np.array([2.0, 1.5, 0.1])
    slope = [(robot.lengths(pose + s) - robot.lengths(pose - s)) / 2e-6 for s in np.eye(3) * 1e-6]
    np.testing.assert_allclose(-robot.structure(pose), slope, atol=1e-8)


def test_a_set_by_name_and_a_file_by_path(planar):
    other = cables(PLANAR_ENDS[::-1]).split("<cables", 1)[1].split(">", 1)[1].replace('id="one"', 'id="two"')
    folder = planar("</cables>", other)
    np.testing.assert_array_equal(load_caspr(folder, "two").anchors[0], [0, 3])
    for name in ("Plate_bodies.xml", "Plate_cables.xml"):
        np.testing.assert_array_equal(load_caspr(folder / name).anchors[0], [0, 0])


def test_a_plane_off_the_origin(model):
    ends = [(a[:-1] + "0.7", b) for a, b in PLANAR_ENDS]
    assert load_caspr(model(BODIES.format(joint="PLANAR_XY", height=0.7), cables(ends))).dimension == "planar"
    with pytest.raises(InputError, match="<cable_ideal> 'cable 1': leaves the plane"):
        load_caspr(model(BODIES.format(joint="PLANAR_XY", height=0), cables(ends)))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    (
        ('type="PLANAR_XY"', 'type="R_Z"', "Plate_bodies.xml, <joint>: type='R_Z'; type as one of PLANAR_XY"),
        ('type="PLANAR_XY"', "", "<joint>: type=None"),
        ("</link_rigid>", '</link_rigid><link_rigid num="2"/>', "<links>: 2 links; a robot with one rigid link"),
        ("<num>0</num>", "<num>1</num>", "<parent>: a parent other than the world"),
        ("<mass>3.5</mass>", "", "<physical>: 0 elements <mass>; exactly one"),
        ("<mass>3.5</mass>", "<mass>heavy</mass>", "<mass>: 'heavy'; 1 finite number"),
        ("<mass>3.5</mass>", "<mass>nan</mass>", "<mass>: 'nan'; 1 finite number"),
        ("<mass>3.5</mass>", "<mass>-1</mass>", r"platform.mass"),
        ("<mass>3.5</mass>", "<mass>1_0</mass>", "<mass>: '1_0'; 1 finite number"),
        ("<mass>3.5</mass>", "<mass/>", "<mass>: ''; 1 finite number"),
        ("<mass>3.5</mass>", f"<mass>{'9' * 9999}x</mass>", r"<mass>: '9+ \.\.\. 9+x'; 1 finite number"),
        ("<num>0</num>", "<num>nan</num>", "<num>: 'nan'; 1 finite number"),
        ("<force_max>101</force_max>", "<force_max>nan</force_max>", "<force_max>: 'nan'"),
        ("<force_min>1</force_min>", "<force_min>-1</force_min>", r"cables.tension_min\[0\]"),
        ("<Izz>0.4</Izz>", "<Izz>0</Izz>", r"platform.inertia"),
        ('ref="com"', 'ref="elbow"', "<inertia>: ref='elbow'"),
        ("0.02 -0.01 0.0", "0.02 -0.01", "<com_location>: '0.02 -0.01'; 3 finite numbers"),
        ('default_cable_set="one"', 'default_cable_set="none"', "<cables>: 0 sets with id 'none'; one of one"),
        ("<cable_ideal name", "<cable_vsd_polynomial name", "not XML"),
        ('reference="joint"', 'reference="tip"', "<cable_ideal> 'cable 1': attachment_reference='tip'"),
        ("<link>0</link>", "<link>1</link>", "<attachment>: the first end is not in the world"),
        ("<link>1</link>", "<link>2</link>", "<attachment>: the second end is not on the link"),
        ("<force_max>101</force_max>", "", "<properties>: 0 elements <force_max>"),
        ("<force_max>101</force_max>", "<force_max>0.5</force_max>", "tension window .* of cable 1 is upside down"),
        ("</attachments>", "<attachment/></attachments>", "'cable 1': 3 attachments; two"),
        ("<bodies_system>", "<robot>", "not XML"),
    ),
)
def test_what_is_not_supported_is_refused_by_its_element(planar, old, new, message):
    with pytest.raises(InputError, match=message) as caught:
        load_caspr(planar(old, new))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("tag", ("cable_vsd_polynomial", "cable_passive_linear_spring", "muscle_hill_type"))
def test_other_cables_are_refused(planar, tag):
    with pytest.raises(InputError, match=f"<{tag}> 'cable 1': this type of cable; one of cable_ideal"):
        load_caspr(planar(tag=tag))


def test_mixed_stiffness_and_pulleys_of_other_kinds_are_refused(planar):
    spring = cable(5, PLANAR_ENDS[0], tag="cable_linear_spring", extra="<K>1e4</K>")
    with pytest.raises(InputError, match="'one': cables with and without stiffness"):
        load_caspr(planar("</cable_set>", spring + "</cable_set>"))
    with pytest.raises(InputError, match="<screw_base_rotating_pulley>: this type of attachment"):
        load_caspr(
            planar(
                "<attachment><link>0</link><location>0 0 0</location></attachment>",
                "<screw_base_rotating_pulley></screw_base_rotating_pulley>",
            )
        )


def test_missing_files_sets_and_cables(planar, tmp_path):
    with pytest.raises(InputError, match=r"0 files \*_bodies.xml"):
        load_caspr(tmp_path)
    with pytest.raises(InputError, match=r"0 files \*_bodies.xml"):
        load_caspr(tmp_path / "nowhere")
    folder = planar()
    with pytest.raises(InputError, match="0 sets with id 'three'"):
        load_caspr(folder, "three")
    (folder / "Plate_cables.xml").write_text('<cables default_cable_set="a"><cable_set id="a"/></cables>')
    with pytest.raises(InputError, match="<cable_set> 'a': no cables"):
        load_caspr(folder)
    (folder / "Plate_cables.xml").unlink()
    with pytest.raises(InputError, match=r"Plate_cables.xml: No such file"):
        load_caspr(folder)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b'<?xml version="1.0" encoding="foo"?><bodies_system/>', "unknown encoding"),
        (b'<?xml version="1.0" encoding="utf-32"?><bodies_system/>', "multi-byte"),
        (b"<a>" * 5000, "not XML"),
        ('<?xml version="1.0"?><bodies_system/>'.encode("utf-32"), "not XML"),
        (b"", "no element found"),
        (bytes(range(256)), "not well-formed"),
        (b"<bodies_system>" + b" " * (1 << 20) + b"</bodies_system>", "more than 1048576 bytes"),
        (LAUGHS.encode(), "defines the entity 'a'; a model without entities"),
        (LAUGHS.replace("?>", ' encoding="utf-16"?>').encode("utf-16"), "defines the entity 'a'"),
        (LAUGHS.replace('"ha"', 'SYSTEM "file:///etc/hostname"').encode(), "defines the entity 'a'"),
    ],
)
def test_files_no_reader_can_take(planar, content, message):
    folder = planar()
    (folder / "Plate_bodies.xml").write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        load_caspr(folder)
    assert caught.value.where.endswith("Plate_bodies.xml")
