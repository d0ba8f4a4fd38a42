import os
import pathlib
import signal
import unittest.mock

from support import DEADLINE_S, RobotTest, main

import hgros

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples" / "python"


class Examples(RobotTest):
    def test_cloud_becomes_an_image(self):
        robot = self.session()
        images = robot.messages("height", timeout=DEADLINE_S)
        programs = [self.program("-B", EXAMPLES / name) for name in ("lidar.py", "height_image.py")]
        pixels = hgros.image(next(images))
        self.assertEqual(pixels.shape, (100, 100))
        self.assertEqual((pixels.min(), pixels.max()), (55, 255))
        for program in programs:
            program.send_signal(signal.SIGINT)
            out, err, code = self.finish(program)
            self.assertEqual((out, err, code), ("", "", 0))

    def test_image_has_no_gaps_where_points_are_on_the_edges_of_pixels(self):
        images = self.session().messages("height", timeout=DEADLINE_S)
        with unittest.mock.patch.dict(os.environ, HGROS_PARAM_cell="0.05"):
            self.program("-B", EXAMPLES / "lidar.py")
            self.program("-B", EXAMPLES / "height_image.py")
        pixels = hgros.image(next(images))
        self.assertEqual((pixels.shape, pixels.min()), ((200, 200), 55))

    def test_first_example_of_the_page_works_as_typed(self):
        code = (ROOT / "docs" / "python.md").read_text().split("```python\n")[1].split("```")[0]
        process = self.python(code)
        self.assertEqual([process.stdout.readline() for _ in range(2)],
                         [f"Scan {number}: the nearest point is 1.5 m away.\n" for number in (1, 2)])
        process.send_signal(signal.SIGINT)
        _, err, exit_code = self.finish(process)
        self.assertEqual(exit_code, -signal.SIGINT, err)

    def test_asyncio_program_of_the_page_ends_at_ctrl_c_without_a_traceback(self):
        blocks = (ROOT / "docs" / "python.md").read_text().split("```python\n")
        code = next(block for block in blocks if "asyncio.run(main())" in block).split("```")[0]
        with unittest.mock.patch.dict(os.environ, PYTHONUNBUFFERED="1"):
            process = self.python(code)
        self.assertEqual(process.stdout.readline(), "one second more\n")
        process.send_signal(signal.SIGINT)
        _, err, exit_code = self.finish(process)
        self.assertEqual((err, exit_code), ("", 0))

    def test_page_shows_the_examples_as_they_are(self):
        page = (ROOT / "docs" / "python.md").read_text()
        for name in ("lidar.py", "height_image.py"):
            with self.subTest(name):
                self.assertIn((EXAMPLES / name).read_text(), page)


if __name__ == "__main__":
    main()
