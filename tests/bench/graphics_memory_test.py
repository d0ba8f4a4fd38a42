#!/usr/bin/env python3
"""Reads the graphics memory of processes from sample output of drivers.

    HGROS_BENCH=<bench> graphics_memory_test.py [TEST...]
"""

import os
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.environ["HGROS_BENCH"], "viewer"))

import graphics_memory  # noqa: E402

MB = 2**20
HEAD = "pos:\t0\nflags:\t02100002\nmnt_id:\t27\nino:\t1023\n"
AMD = HEAD + """drm-driver:\tamdgpu
drm-pdev:\t0000:0c:00.0
drm-client-id:\t41
drm-memory-vram:\t1024 KiB
drm-memory-gtt: \t512 KiB
drm-memory-cpu: \t0 KiB
drm-engine-gfx:\t7500 ns
"""
INTEL = HEAD + """drm-driver: i915
drm-client-id: 9
drm-total-system0: 40 MiB
drm-shared-system0: 4 MiB
drm-active-system0: 0
drm-resident-system0: 24 MiB
drm-engine-render: 5 ns
"""
NVIDIA = """<?xml version="1.0" ?>
<!DOCTYPE nvidia_smi_log SYSTEM "nvsmi_device_v12.dtd">
<nvidia_smi_log><gpu id="00000000:01:00.0"><processes>
<process_info><pid>77</pid><type>G</type><process_name>viewer</process_name><used_memory>120 MiB</used_memory></process_info>
<process_info><pid>78</pid><type>C</type><process_name>other</process_name><used_memory>999 MiB</used_memory></process_info>
<process_info><pid>79</pid><type>G</type><process_name>hidden</process_name><used_memory>N/A</used_memory></process_info>
</processes></gpu></nvidia_smi_log>
"""


class GraphicsMemory(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="hgros_graphics_test_")
        self.addCleanup(folder.cleanup)
        self.proc = pathlib.Path(folder.name)

    def open_files(self, *texts):
        files = self.proc / "5" / "fdinfo"
        files.mkdir(parents=True)
        for number, text in enumerate(texts):
            (files / str(number)).write_text(text)
        return graphics_memory.told_by_kernel(5, self.proc)

    def test_counts_only_the_cards_own_memory(self):
        self.assertEqual(self.open_files(HEAD, AMD), 1 * MB)

    def test_adds_all_regions_if_the_card_has_no_memory(self):
        self.assertEqual(self.open_files(AMD.replace("vram", "stolen")), 1.5 * MB)

    def test_prefers_resident_to_requested_memory(self):
        self.assertEqual(self.open_files(INTEL), 24 * MB)

    def test_counts_each_client_once(self):
        other = AMD.replace("client-id:\t41", "client-id:\t42")
        self.assertEqual(self.open_files(AMD, AMD, other, INTEL), 2 * MB + 24 * MB)

    def test_counts_each_file_if_the_driver_names_no_clients(self):
        nameless = "drm-driver: old\ndrm-memory-vram: 1 MiB\n"
        self.assertEqual(self.open_files(nameless, nameless), 2 * MB)

    def test_returns_none_for_a_process_without_a_card(self):
        self.assertIsNone(self.open_files(HEAD, "drm-driver: vgem\ndrm-engine-x: 4 ns\n", "drm-driver: x\ndrm-memory-y: much\n"))
        self.assertIsNone(graphics_memory.told_by_kernel(6, self.proc))
        self.assertIsNone(graphics_memory.told_by_kernel(os.getpid()))

    def test_reads_the_output_of_nvidia_smi(self):
        self.assertEqual(graphics_memory.told_by_nvidia(77, NVIDIA), 120 * MB)
        self.assertIsNone(graphics_memory.told_by_nvidia(79, NVIDIA))
        self.assertIsNone(graphics_memory.told_by_nvidia(80, NVIDIA))
        self.assertIsNone(graphics_memory.told_by_nvidia(77, "NVIDIA-SMI has failed\n"))

    def test_detects_whether_there_is_a_card(self):
        self.assertFalse(graphics_memory.has_card(self.proc, None))
        self.assertTrue(graphics_memory.has_card(self.proc, "nvidia-smi"))
        (self.proc / "renderD128").touch()
        self.assertTrue(graphics_memory.has_card(self.proc, None))

    def test_keeps_the_peak_of_several_readings(self):
        program = self.proc / "nvidia-smi"
        peak = graphics_memory.Peak(77, self.proc, str(program))
        for size in ("50", "70", "60", "nothing"):
            program.write_text("#!/bin/sh\ncat <<'END'\n" + NVIDIA.replace("120", size) + "END\n")
            program.chmod(0o755)
            peak.smi_at = 0
            peak.look()
        program.unlink()
        peak.smi_at = 0
        peak.look()
        self.assertEqual(peak.bytes, 70 * MB)


if __name__ == "__main__":
    unittest.main()
