#!/usr/bin/python3
"""Virtual frames that are exact renders: kept under their keyframes, found again, and marked in the loops."""

import copy
import sys
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray

from flight import VIRTUAL, Flight, NodeOutputs, wait_until

SPEED = 1.5


class VirtualTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.flight = Flight(rospy.get_param("~flight"))
        cls.outputs = NodeOutputs({"/diagnostics": DiagnosticArray})
        cls.flight.wait_for_node()
        cls.views = 0
        cls.flight.play(SPEED, cls.edit)
        cls.outputs.wait_for_keyframe(cls.flight.keyframe_stamps()[-1])

    @classmethod
    def edit(cls, topic, message):
        """Every tenth view comes twice; the fifth one again with a depth too few, and as nobody's."""
        if topic != VIRTUAL:
            return [(topic, message)]
        cls.views += 1
        messages = [(topic, message)]
        if cls.views % 10 == 0:
            messages.append((topic, message))
        if cls.views == 5:
            broken = copy.deepcopy(message)
            broken.depth = broken.depth[:-1]
            unknown = copy.deepcopy(message)
            unknown.header.stamp -= rospy.Duration(1000.0)
            messages += [(topic, broken), (topic, unknown)]
        return messages

    def diagnosis(self):
        statuses = [s for m in self.outputs["/diagnostics"] for s in m.status]
        return {v.key: v.value for v in statuses[-1].values} if statuses else {}

    def test_every_view_is_accounted_for(self):
        keyframes = str(len(self.flight.keyframe_stamps()))
        wait_until(lambda: self.diagnosis().get("keyframes") == keyframes, 10.0, "the diagnostics")
        # The last keyframe's views come after it.
        sent = self.views + self.views // 10 + 1
        wait_until(
            lambda: self.diagnosis().get("virtual views received") == str(sent), 20.0, f"{sent} virtual views"
        )
        values = self.diagnosis()
        count = lambda key: int(values[f"virtual views {key}"])
        self.assertGreater(self.views, 50)
        self.assertEqual(count("received"), sent)
        self.assertEqual(count("waiting for their keyframe"), 1)
        self.assertEqual(values["keyframes refused"], "1", "the one with a depth too few")
        self.assertGreater(count("kept"), 10)
        fates = ["duplicate", "refused", "no_keyframe", "no_place", "uncertain", "disagrees", "surpassed"]
        dropped = sum(count(f"dropped: {fate}") for fate in fates)
        self.assertEqual(count("kept") + dropped + 1, count("received"))
        self.assertEqual(count("dropped: disagrees"), 0, "they are exact")
        self.assertEqual(count("dropped: queue full"), 0)
        self.assertLess(int(values["memory of virtual views [kB]"]), 20 * count("kept"))

    def test_loops_that_need_views_are_marked_and_right(self):
        accepted = self.outputs.accepted()
        self.assertGreater(len([loop for loop in accepted if loop.is_virtual]), 0)
        for loop in accepted:
            self.assertLess(self.flight.loop_error(loop), 0.4)


if __name__ == "__main__":
    rospy.init_node("virtual_test")
    rostest.rosrun("deja_view", "virtual_test", VirtualTest, sys.argv)
