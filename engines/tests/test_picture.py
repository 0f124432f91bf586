"""The picture of error over cost."""

import unittest
import xml.etree.ElementTree as xml

import support  # noqa: F401

from stiction_engines import picture


def cell(engine, settings, error, cost, case="slide-0", measure="stop_distance", outcome="passed"):
    return {
        "scenario": case,
        "outcome": outcome,
        "method": engine,
        "integrator": settings,
        f"error_{measure}": error,
        "cpu_s": cost,
        "duration_s": "0.5",
    }


class Picture(unittest.TestCase):
    def drawn(self, cells):
        root = xml.fromstring(picture.svg(cells))
        name = lambda element: element.tag.split("}")[1]
        return [element for element in root.iter() if name(element) in ("polyline", "circle")], picture.svg(
            cells
        )

    def test_a_curve_per_engine_and_settings(self):
        cells = [
            cell("a", "default", "-1e-3", "0.05"),
            cell("a", "default", "2e-4", "0.5"),
            cell("b", "exact", "0.0", "0.01"),
            cell("b", "exact", "inf", "0.02"),
            cell("c", "default", "1.0", ""),
            cell("d", "default", "", "", outcome="unsupported"),
        ]
        shapes, text = self.drawn(cells)
        lines = [shape.get("points").split() for shape in shapes if "points" in shape.attrib]
        self.assertEqual(sorted(len(line) for line in lines), [1, 2])
        self.assertEqual(len(shapes), 5)
        # Errors of 0 are drawn at the floor of the picture; the errors span 13 decades down to it.
        (lowest,) = [line for line in lines if len(line) == 1]
        self.assertAlmostEqual(float(lowest[0].split(",")[1]), picture.HEIGHT - picture.BOTTOM, delta=0.1)
        self.assertIn("a default", text)
        self.assertEqual(text.count("not measured"), len(picture.PANELS) - 1)

    def test_axes_cover_whole_decades(self):
        axis = picture._Axis([2e-4, 3e-2], 0.0, 100.0)
        self.assertEqual((axis.first, axis.last), (-4, -1))
        self.assertAlmostEqual(axis.at(1e-4), 0.0)
        self.assertAlmostEqual(axis.at(1e-1), 100.0)
        self.assertAlmostEqual(axis.at(10**-2.5), 50.0)


if __name__ == "__main__":
    unittest.main()
