"""Reading of cases, whole and broken."""

import json
import unittest

from support import FolderTest, case_data

import numpy

from stiction_engines import case, measure


class Broken(FolderTest):
    def refused(self, text, message):
        file = self.folder / "broken.json"
        if text is not None:
            file.write_text(text)
        with self.assertRaises(case.CaseError) as caught:
            case.read(file)
        self.assertEqual(str(caught.exception), f"{file}: {message}")

    def test_no_file(self):
        self.refused(None, "No such file or directory")

    def test_no_json(self):
        self.refused('{"format":\n oops}', "line 2: Expecting value")

    def test_wrong_format(self):
        text = json.dumps(case_data(format="stiction-case-9"))
        self.refused(text, "`format` is 'stiction-case-9', expected 'stiction-case-1'")

    def test_missing_keys(self):
        for key in ["format", "name", "gravity", "bodies", "duration", "measures"]:
            data = case_data()
            del data[key]
            self.refused(json.dumps(data), f"the key '{key}' is missing")
        data = case_data()
        del data["measures"][0]["truth_error"]
        self.refused(json.dumps(data), "the key 'truth_error' is missing")

    def test_wrong_servo(self):
        data = case_data()
        data["bodies"][0]["servos"] = {"joint": {"kp": 1.0, "kd": 0.1, "angle": 0.0}}
        self.refused(json.dumps(data), "Servo.__init__() got an unexpected keyword argument 'angle'")


class Whole(FolderTest):
    def test_values(self):
        known = self.case()
        self.assertEqual(known.restitution, 0.0)
        self.assertEqual(known.measures[0].parameters, {"direction": [1, 0, 0]})
        numpy.testing.assert_array_equal(known.bodies[0].orientation, [1, 0, 0, 0])

    def test_forces_are_linear_between_knots_and_zero_outside(self):
        force = {
            "body": "box",
            "link": "box",
            "point": [0, 0, 0],
            "knots": [[1, 0, 0, 0, 0, 0, 0], [3, 4, 0, 0, 0, 0, 8]],
        }
        (known,) = self.case(case_data(forces=[force])).forces
        for time, push, moment in [(0.9, 0, 0), (2, 2, 4), (3, 4, 8), (3.1, 0, 0)]:
            numpy.testing.assert_allclose(known.at(time), [[push, 0, 0], [0, 0, moment]])

    def test_cases_of_the_package(self):
        cases = case.read_all()
        self.assertGreater(len(cases), 30)
        for known in cases:
            self.assertTrue(known.measures, known.name)
            self.assertEqual(known.name, known.file.stem)
            for entry in known.measures:
                self.assertIn(entry.kind, [*measure.KINDS, *measure.MECHANICAL], known.name)
                self.assertIn(entry.body, [body.name for body in known.bodies], known.name)
            for body in known.bodies:
                self.assertTrue(body.urdf.is_file(), body.urdf)

    def test_selection_by_parts_of_names(self):
        self.assertEqual([known.name for known in case.read_all(["slide-4"])], ["slide-45"])


if __name__ == "__main__":
    unittest.main()
