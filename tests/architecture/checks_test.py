"""Feeds deliberately wrong trees to the checks: a check that finds nothing has to be known to look."""

import pathlib
import tempfile
import unittest

import check_house
import check_rows


class Tree(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


class RowsTest(Tree):
    def faults(self):
        return check_rows.check_tree(self.root)[0]

    def assert_one_fault(self, path, line, words):
        faults = self.faults()
        self.assertEqual(len(faults), 1, faults)
        self.assertTrue(faults[0].startswith(f"{path}:{line}: "), faults[0])
        self.assertIn(words, faults[0])

    def test_arrows_to_the_rows_above_and_to_itself_are_good(self):
        self.write("include/hgros/base/error.hpp", "#include <string>\n")
        self.write("include/hgros/codec/packet.hpp", '#include "hgros/base/error.hpp"\n')
        self.write("src/codec/reader.hpp", "#pragma once\n")
        self.write("src/codec/packet.cpp", '#include "hgros/codec/packet.hpp"\n#include "codec/reader.hpp"\n'
                                           '#include "reader.hpp"\n#include <zmq.h>\n#include <spdlog/spdlog.h>\n')
        self.write("src/transport/zmq/socket.cpp", '#include "transport/shm/segment.hpp"\n')
        self.write("include/hgros/hgros.hpp", '#include "hgros/record/writer.hpp"\n')
        self.write("apps/hgros/main.cpp", '#include <hgros/hgros.hpp>\n#include <hgros/Imu.pb.h>\n')
        self.write("tests/codec/packet_test.cpp", '#include "codec/reader.hpp"\n')
        self.assertEqual(self.faults(), [])

    def test_an_arrow_to_a_row_below_is_a_fault(self):
        self.write("src/graph/channel.cpp", '\n#include "hgros/session/session.hpp"\n')
        self.assert_one_fault("src/graph/channel.cpp", 2, "which is below it")

    def test_an_arrow_to_a_sibling_is_a_fault(self):
        self.write("include/hgros/graph/graph.hpp", "#include <hgros/transport/transport.hpp>\n")
        self.assert_one_fault("include/hgros/graph/graph.hpp", 1, "its sibling in row 2")

    def test_a_private_header_of_another_module_is_a_fault(self):
        self.write("src/session/session.cpp", '#include "graph/ring.hpp"\n')
        self.assert_one_fault("src/session/session.cpp", 1, "private to graph")

    def test_a_private_header_reached_by_a_relative_path_is_a_fault(self):
        self.write("src/graph/ring.hpp", "")
        self.write("src/session/session.cpp", '#include "../graph/ring.hpp"\n')
        self.assert_one_fault("src/session/session.cpp", 1, "private to graph")

    def test_a_private_header_in_a_public_one_is_a_fault(self):
        self.write("include/hgros/graph/graph.hpp", '#include "graph/ring.hpp"\n')
        self.assert_one_fault("include/hgros/graph/graph.hpp", 1, "which is private")

    def test_a_hidden_library_in_a_public_header_is_a_fault(self):
        for name in ("zmq.h", "zmq.hpp", "spdlog/spdlog.h", "yaml-cpp/yaml.h", "sys/mman.h"):
            with self.subTest(name):
                self.write("include/hgros/base/log.hpp", f"#include <{name}>\n")
                self.assert_one_fault("include/hgros/base/log.hpp", 1, "implementation detail")

    def test_an_app_that_looks_inside_is_a_fault(self):
        self.write("apps/viewer/main.cpp", '#include "session/bridge.hpp"\n')
        self.assert_one_fault("apps/viewer/main.cpp", 1, "private to session")

    def test_an_unknown_module_is_a_fault(self):
        self.write("src/extras/extra.cpp", "")
        self.assert_one_fault("src/extras/extra.cpp", 1, "not a module of any row")

    def test_an_include_in_a_comment_is_none(self):
        self.write("src/base/error.cpp", '/*\n#include "hgros/session/session.hpp"\n*/\n// #include "hgros/graph/a.hpp"\n')
        self.assertEqual(self.faults(), [])


class HouseTest(Tree):
    def faults(self):
        return check_house.check_tree(self.root)[0]

    def test_good_code_is_good(self):
        self.write("include/hgros/base/a.hpp", "#pragma once\n#define HGROS_EXPORT x\n/// Never a static function.\n"
                                               "std::shared_ptr<const void> owner;\n")
        self.write("src/base/a.cpp", 'std::fprintf(stderr, "std::cout"); std::snprintf(a, 1, "x"); // sleep_for\n'
                                     "static int counted;\n")
        self.write("apps/hgros/main.cpp", 'std::puts("an app may");\n')
        self.write("tests/base/a_test.cpp", "google::protobuf::util::MessageDifferencer::Equals(a, b);\n"
                                            'const char* text = R"(std::this_thread::sleep_for)";\n')
        self.assertEqual(self.faults(), [])

    def test_every_rule_finds_its_fault(self):
        wrong = [
            ("src/base/a.cpp", "std::this_thread::sleep_for(1s);", "sleeps"),
            ("tests/base/a_test.cpp", "usleep(3);", "sleeps"),
            ("src/base/a.cpp", "std::shared_ptr<void> any;", "without its type"),
            ("src/base/a.cpp", "class QueueManager {};", "name the thing"),
            ("src/base/a.cpp", "namespace util {}", "name the thing"),
            ("src/base/string_utils.cpp", "", "file name"),
            ("src/base/a.cpp", "// TO" + "DO: later", "leaves a TO" + "DO"),
            ("include/hgros/a.hpp", "#pragma once\n#define HGROS_LOG(x) x", "macro"),
            ("include/hgros/a.hpp", "#pragma once\nstatic int Zero() { return 0; }", "static"),
            ("include/hgros/a.hpp", "#pragma once\nusing namespace std;", "opens a namespace"),
            ("include/hgros/a.hpp", "int a;", "#pragma once"),
            ("src/base/a.cpp", 'std::cout << "x";', "standard output"),
            ("src/base/a.cpp", 'printf("x");', "standard output"),
            ("src/base/a.cpp", 'std::puts("x");', "standard output"),
        ]
        for path, text, words in wrong:
            with self.subTest(text=text, path=path):
                self.write(path, text + "\n")
                faults = self.faults()
                self.assertEqual(len(faults), 1, faults)
                self.assertIn(words, faults[0])
                (self.root / path).unlink()

    def test_a_fault_is_reported_at_its_line(self):
        self.write("src/base/a.cpp", "/* one\ntwo */\nusleep(3);\n")
        self.assertTrue(self.faults()[0].startswith("src/base/a.cpp:3: "), self.faults())


if __name__ == "__main__":
    unittest.main()
