"""Runs the checks on deliberately wrong trees, to show that they find faults."""

import pathlib
import tempfile
import unittest

import check_docs
import check_house
import check_layers


class Tree(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")

    def assert_one_fault(self, path, text, line, words):
        self.write(path, text)
        faults = self.faults()
        self.assertEqual(len(faults), 1, faults)
        self.assertTrue(faults[0].startswith(f"{path}:{line}: "), faults[0])
        self.assertIn(words, faults[0])
        (self.root / path).unlink()


class LayersTest(Tree):
    def faults(self):
        return check_layers.check_tree(self.root)[0]

    def test_includes_of_lower_layers_and_of_the_same_module_are_good(self):
        self.write("include/hgros/base/error.hpp", "#include <string>\n")
        self.write("include/hgros/internal/codec/packet.hpp", '#include "hgros/base/error.hpp"\n')
        self.write("src/codec/reader.hpp", "#pragma once\n")
        self.write("src/codec/packet.cpp", '#include "hgros/internal/codec/packet.hpp"\n#include "codec/reader.hpp"\n'
                                           '#include "reader.hpp"\n#include <zmq.h>\n#include <spdlog/spdlog.h>\n')
        self.write("src/transport/zmq/socket.cpp", '#include "transport/shm/segment.hpp"\n')
        self.write("include/hgros/hgros.hpp", '#include "hgros/params/param_server.hpp"\n')
        self.write("apps/hgros/main.cpp", '#include <hgros/hgros.hpp>\n#include <hgros/Imu.pb.h>\n')
        self.write("tests/codec/packet_test.cpp", '#include "codec/reader.hpp"\n')
        # A shared header is for modules above its own; an internal one has the layer of its module. Comments are ignored.
        self.write("src/session/session.cpp", '#include "hgros/graph/outlet.hpp"\n')
        self.write("include/hgros/graph/graph.hpp", '#include "hgros/internal/graph/callback.hpp"\n')
        self.write("src/base/error.cpp", '/*\n#include "hgros/session/session.hpp"\n*/\n// #include "hgros/graph/a.hpp"\n')
        self.write_shared()
        self.assertEqual(self.faults(), [])

    def write_shared(self):
        self.write("src/graph/ring.hpp", "")
        for path in ("src/include/hgros/graph/outlet.hpp", "src/include/hgros/base/fifo.hpp",
                     "include/hgros/internal/graph/callback.hpp", "include/hgros/internal/base/call_site.hpp"):
            self.write(path, "#pragma once\n")

    def test_every_rule_finds_its_fault(self):
        self.write_shared()
        graph, log = "include/hgros/graph/graph.hpp", "include/hgros/base/log.hpp"
        session, viewer = "src/session/session.cpp", "apps/viewer/main.cpp"
        wrong = [
            ("a higher layer", "src/graph/channel.cpp", '\n#include "hgros/session/session.hpp"', "which is above it"),
            ("the same layer", graph, "#include <hgros/transport/transport.hpp>", "which is in the same layer (2)"),
            ("private to another module", session, '#include "graph/ring.hpp"', "private to graph"),
            ("private, by a relative path", session, '#include "../graph/ring.hpp"', "private to graph"),
            ("private, from the root", session, '#include "src/graph/ring.hpp"', "private to graph"),
            ("private in a public header", graph, '#include "graph/ring.hpp"', "which is private"),
            ("shared, in a lower module", "src/base/error.cpp", '#include "hgros/graph/outlet.hpp"', "which is above it"),
            ("not installed, in a public header", graph, '#include "hgros/base/fifo.hpp"', "which is not installed"),
            ("not installed, in an app", viewer, '#include "hgros/base/fifo.hpp"', "private to base"),
            ("internal, in a lower module", "src/codec/packet.cpp", '#include "hgros/internal/graph/callback.hpp"',
             "which is above it"),
            ("internal, in an app", viewer, '#include "hgros/internal/base/call_site.hpp"', "may change at any time"),
            ("private, in an app", viewer, '#include "session/bridge.hpp"', "private to session"),
            ("an unknown module", "src/extras/extra.cpp", "", "is in no layer"),
        ]
        wrong += [(f"the hidden library {name}", log, f"#include <{name}>", "implementation detail")
                  for name in ("zmq.h", "zmq.hpp", "spdlog/spdlog.h", "yaml-cpp/yaml.h", "sys/mman.h", "fcntl.h")]
        for what, path, text, words in wrong:
            with self.subTest(what):
                self.assert_one_fault(path, text + "\n", text.count("\n") + 1, words)


class HouseTest(Tree):
    def faults(self):
        return check_house.check_tree(self.root)[0]

    def test_good_code_has_no_fault(self):
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
            ("tests/base/a_test.cpp", "/* one\ntwo */\nusleep(3);", "sleeps"),
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
                self.assert_one_fault(path, text + "\n", text.count("\n") + 1, words)

    def test_files_up_to_the_limits_have_no_fault(self):
        self.write("src/base/a.cpp", "int a;\n" * 400)
        self.write("include/hgros/a.hpp", "#pragma once\n" + "int a;\n" * 149)
        self.write("tests/base/a_test.cpp", "int a;\n" * 500)
        for number in range(29):
            self.write(f"src/base/file_{number}.cpp", "")
        self.write("src/base/deeper/b.cpp", "")
        self.write("src/base/CMakeLists.txt", "")
        self.assertEqual(self.faults(), [])

    def test_a_file_beyond_the_limit_is_a_fault(self):
        for path, lines, words in [
            ("src/base/a.cpp", 401, "more than 400 lines"),
            ("src/base/a.hpp", 401, "more than 400 lines"),
            ("apps/viewer/app/a.cpp", 401, "more than 400 lines"),
            ("include/hgros/a.hpp", 151, "more than 150 lines"),
        ]:
            with self.subTest(path=path):
                self.assert_one_fault(path, "#pragma once\n" * lines, lines, words)

    def test_a_folder_with_too_many_sources_is_a_fault(self):
        for number in range(31):
            self.write(f"src/base/file_{number}.{'hpp' if number % 2 else 'cpp'}", "#pragma once\n")
        faults = self.faults()
        self.assertEqual(len(faults), 1, faults)
        self.assertTrue(faults[0].startswith("src/base:1: has 31 source files"), faults[0])

    def test_a_class_that_is_too_large_in_all_its_files_is_a_fault(self):
        member = "int Ring::Count(int n) const {\n" + "  ++n;\n" * 120 + "}\n\n"
        for head in ("class Ring", "class Ring final", "struct HGROS_EXPORT Ring : public Base", "class alignas(64) Ring :\n  Base",
                     "template <class T> class Ring"):
            with self.subTest(head):
                first_lines = head.count("\n") + 1
                body = f"#pragma once\nclass Other;\n{head} {{\n" + "  int a;\n" * (131 - first_lines) + "};\n"
                self.write("include/hgros/graph/ring.hpp", body)
                self.write("src/graph/ring.cpp", member * 2)
                self.write("src/graph/ring_more.cpp", member + "Ring::Ring() = default;\n")
                self.write("src/clock/ring.cpp", member * 2)  # another class of that name
                self.assertEqual(self.faults(), [])
                self.write("src/graph/ring_more.cpp", member + "Ring::~Ring() {\n  End();\n}\n")
                self.assertEqual(len(self.faults()), 1, self.faults())
                self.assertIn("graph: class Ring has 501 lines", self.faults()[0])


class DocsTest(Tree):
    def faults(self):
        return check_docs.check_tree(self.root)[0]

    def test_good_pages_have_no_fault(self):
        self.write("docs/tf.md", "# Transforms & `trees`, in short\n\nText.\n")
        self.write("docs/images/map.png", "")
        self.write("README.md", "[a](docs/tf.md) [b](docs/tf.md#transforms--trees-in-short) [c](#title) ![d](docs/images/map.png)\n"
                                "[web](https://example.org/nothing) `carrier`, `[span](nowhere.md)`\n\n# Title\n\n"
                                "    [](const Message& message) {}\n\n```cpp\n[](int) {}\n```\n\n# What is it\n\nWho reads this?\n"
                                f"- [{'long ' * 30}](docs/tf.md)\n- https://example.org/{'long' * 40}\n")
        self.assertEqual(self.faults(), [])

    def test_a_long_line_is_a_fault_in_text_tables_and_code(self):
        for text, line, words in ((f"{'word ' * 27}", 1, "break it"), (f"| {'cell ' * 27}|", 1, "shorten a cell"),
                                  (f"\n    {'code ' * 27}", 2, "break it"), (f"```\n{'code ' * 27}\n```", 2, "break it")):
            with self.subTest(text=text):
                self.assert_one_fault("docs/page.md", text + "\n", line, words)

    def test_a_dead_link_is_a_fault(self):
        self.assert_one_fault("docs/page.md", "\nSee [this](other.md).\n", 2, 'links to "other.md"')
        self.assert_one_fault("docs/page.md", "# A\n\nSee [this](page.md#b).\n", 3, "no such heading")
        self.assert_one_fault("docs/page.md", "# A\n\nSee [this](#b).\n", 3, "no such heading")
        self.assert_one_fault("docs/page.md", "![map](images/map.png)\n", 1, 'links to "images/map.png"')

    def test_forbidden_words_are_faults(self):
        wrong = [
            ("The carrier takes it.", "write transport"),
            ("```yaml\nscan: {carriers: zmq}\n```", "write transport"),
            ("It is read anew.", "write again"),
            ("All but for one.", "write except for"),
            ("Told to whoever asks.", "name the subject"),
            ("So many are kept.", "as many as"),
            ("The colour of it.", "write color"),
            ("It is recognised.", "write -ize"),
            ("Who reads it must wait.", 'begins a sentence with "Who"'),
            ("Good. Of these, two are left.", 'begins a sentence with "Of"'),
            ("- *What is* left out stays.", 'begins a sentence with "What is"'),
        ]
        for text, words in wrong:
            with self.subTest(text=text):
                self.assert_one_fault("README.md", text + "\n", 2 if text.startswith("```") else 1, words)

    def test_the_page_of_platforms_names_what_only_linux_has(self):
        self.write("src/base/a.cpp", "#include <sys/epoll.h>\n")
        self.write("docs/platforms.md", "`src/base/a.cpp`\n")
        self.assertEqual(self.faults(), [])
        self.assert_one_fault("docs/platforms.md", "Nothing.\n", 1, "does not name src/base/a.cpp, which includes <sys/epoll.h>")
        self.assert_one_fault("docs/platforms.md", "`src/base/a.cpp`, `src/base/b.cpp`\n", 1, "names src/base/b.cpp")

    def test_pages_in_build_folders_are_ignored(self):
        self.write("build/dev/page.md", "The carrier takes it.\n")
        self.write(".cache/page.md", "The carrier takes it.\n")
        self.assertEqual(check_docs.check_tree(self.root), ([], 0))


if __name__ == "__main__":
    unittest.main()
