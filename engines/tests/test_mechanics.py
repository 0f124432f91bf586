"""Energy and momentum of bodies against closed forms."""

import math
import unittest

from support import FolderTest, about, body_series, case_data

import numpy

from stiction_engines.mechanics import Mechanism

GRAVITY = numpy.array([0, 0, -9.81])


class RotatingBox(FolderTest):
    """A box with its centre of mass off its frame and its axes of inertia turned by 90 degrees about z."""

    URDF = """<robot name="box"><link name="box"><inertial>
    <origin xyz="0.1 0 0" rpy="0 0 1.5707963267948966"/>
    <mass value="3"/><inertia ixx="0.1" iyy="0.2" izz="0.3"/></inertial></link></robot>"""

    def totals(self, **motion):
        mechanism = Mechanism(self.case(urdf=self.URDF).bodies[0])
        return mechanism, mechanism.totals(body_series(1, **motion), 0, GRAVITY)

    def test_about_an_axis_of_its_own(self):
        # Turned by 90 degrees about z: the link's x is the world's y. The moment of inertia about it is 0.2.
        mechanism, (kinetic, potential, momentum, angular, centre) = self.totals(
            position=[[1, 2, 3]], orientation=about([0, 0, 1], [math.pi / 2]), angular_velocity=[[0, 5, 0]]
        )
        self.assertAlmostEqual(mechanism.mass, 3)
        numpy.testing.assert_allclose(centre, [1, 2.1, 3])
        self.assertAlmostEqual(kinetic, 0.5 * 0.2 * 25)
        self.assertAlmostEqual(potential, 3 * 9.81 * 3)
        numpy.testing.assert_allclose(momentum, [0, 0, 0], atol=1e-12)
        numpy.testing.assert_allclose(angular, [0, 0.2 * 5, 0], atol=1e-12)

    def test_speed_of_the_centre_of_mass(self):
        # w = 2 about z moves the centre at 0.2 m/s along y, on top of the origin's velocity.
        _, (kinetic, _, momentum, angular, _) = self.totals(
            linear_velocity=[[1, 0, 0]], angular_velocity=[[0, 0, 2]]
        )
        self.assertAlmostEqual(kinetic, 0.5 * 3 * (1 + 0.04) + 0.5 * 0.3 * 4)
        numpy.testing.assert_allclose(momentum, [3, 0.6, 0], atol=1e-12)
        numpy.testing.assert_allclose(angular, [0, 0, 0.1 * 0.6 + 0.3 * 2], atol=1e-12)


class TwoLinkArm(FolderTest):
    """A planar arm of two links on a base that rests: the textbook's closed forms."""

    L1, C1, C2, M1, M2, I1, I2, ROTOR = 0.5, 0.2, 0.15, 2.0, 1.5, 0.03, 0.02, 0.004
    URDF = f"""<robot name="box">
    <link name="box"><inertial><mass value="4"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <link name="lower"><inertial><origin xyz="{C2} 0 0"/><mass value="{M2}"/>
      <inertia ixx="0.1" iyy="0.1" izz="{I2}"/></inertial></link>
    <link name="upper"><inertial><origin xyz="{C1} 0 0"/><mass value="{M1}"/>
      <inertia ixx="0.1" iyy="0.1" izz="{I1}"/></inertial></link>
    <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="{L1} 0 0"/>
      <axis xyz="0 0 1"/></joint>
    <joint name="shoulder" type="continuous"><parent link="box"/><child link="upper"/>
      <axis xyz="0 0 1"/></joint>
    </robot>"""

    def test_energy_and_momentum(self):
        data = case_data()
        data["bodies"][0]["armature"] = {"shoulder": self.ROTOR}
        mechanism = Mechanism(self.case(data, self.URDF).bodies[0])
        # The file has the elbow first.
        self.assertEqual(mechanism.moving, ["elbow", "shoulder"])
        q1, q2, w1, w2 = 0.7, -1.1, 1.3, 2.1
        motion = body_series(1, q=[[q2, q1]], qd=[[w2, w1]])
        kinetic, potential, momentum, angular, centre = mechanism.totals(
            motion, 0, numpy.array([0, -9.81, 0])
        )
        both, cosine = w1 + w2, math.cos(q2)
        square = self.L1**2 * w1**2 + self.C2**2 * both**2 + 2 * self.L1 * self.C2 * w1 * both * cosine
        energy = (self.I1 + self.M1 * self.C1**2 + self.ROTOR) * w1**2 + self.I2 * both**2 + self.M2 * square
        self.assertAlmostEqual(kinetic, energy / 2, places=12)
        arm1, arm2 = [numpy.array([math.cos(a), math.sin(a), 0]) for a in (q1, q1 + q2)]
        side1, side2 = [numpy.array([-a[1], a[0], 0]) for a in (arm1, arm2)]
        centre1, centre2 = self.C1 * arm1, self.L1 * arm1 + self.C2 * arm2
        self.assertAlmostEqual(potential, 9.81 * (self.M1 * centre1[1] + self.M2 * centre2[1]), places=12)
        numpy.testing.assert_allclose(centre, (self.M1 * centre1 + self.M2 * centre2) / 7.5, atol=1e-12)
        expected = self.M1 * self.C1 * w1 * side1 + self.M2 * (self.L1 * w1 * side1 + self.C2 * both * side2)
        numpy.testing.assert_allclose(momentum, expected, atol=1e-12)
        turning = (self.I1 + self.M1 * self.C1**2 + self.M2 * self.L1**2) * w1 + (
            self.I2 + self.M2 * self.C2**2
        ) * both
        turning += self.M2 * self.L1 * self.C2 * cosine * (2 * w1 + w2)
        numpy.testing.assert_allclose(angular, [0, 0, turning], atol=1e-12)

    def test_prismatic_joint_carries_its_child(self):
        urdf = self.URDF.replace('type="continuous"', 'type="prismatic"')
        mechanism = Mechanism(self.case(urdf=urdf).bodies[0])
        motion = body_series(1, q=[[0.0, 0.3]], qd=[[0.0, 2.0]])
        kinetic, _, momentum, _, centre = mechanism.totals(motion, 0, GRAVITY)
        self.assertAlmostEqual(kinetic, 0.5 * 3.5 * 4)
        numpy.testing.assert_allclose(momentum, [0, 0, 7], atol=1e-12)
        self.assertAlmostEqual(centre[2], 3.5 * 0.3 / 7.5)

    def test_a_loop_is_refused(self):
        urdf = self.URDF.replace('<parent link="box"/>', '<parent link="lower"/>')
        with self.assertRaisesRegex(ValueError, "tree"):
            Mechanism(self.case(urdf=urdf).bodies[0])


if __name__ == "__main__":
    unittest.main()
