"""Reads the windows on a message bus as a screen reader does, prints them and uses two controls.

Prints role, name and whether it takes the focus, of everything that is there, as JSON; then presses
the button Pause and sets the slider Stiffness to 5000.
"""

import json
import sys
import time

import gi

gi.require_version("Atspi", "2.0")
from gi.repository import Atspi, Gio, GLib  # noqa: E402

PATIENCE = 60.0


def say_that_one_reads():
    """Programs tell nothing before somebody reads."""
    value = GLib.Variant("(ssv)", ("org.a11y.Status", "IsEnabled", GLib.Variant("b", True)))
    bus = Gio.bus_get_sync(Gio.BusType.SESSION)
    properties = "org.freedesktop.DBus.Properties"
    bus.call_sync("org.a11y.Bus", "/org/a11y/bus", properties, "Set", value, None, 0, -1, None)


def below(node):
    """A node and all in it."""
    yield node
    for row in range(node.get_child_count()):
        child = node.get_child_at_index(row)
        if child is not None:
            yield from below(child)


def everything():
    """All nodes by role and name, once there is a button to pause; they come with a frame."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        try:
            desktop = Atspi.get_desktop(0)
            desktop.clear_cache()
            nodes = [(node.get_role_name(), node.get_name() or "", node) for node in below(desktop)]
            if any(name == "Pause" for _, name, _ in nodes):
                return nodes
        except GLib.Error as error:
            # What is drawn anew in the meantime is gone.
            print(error, file=sys.stderr)
        time.sleep(0.2)
    sys.exit("no window was told of")


def the(role, name):
    return next(node for one, other, node in nodes if (one, other) == (role, name))


say_that_one_reads()
nodes = everything()
focusable = Atspi.StateType.FOCUSABLE
rows = [(role, name, node.get_state_set().contains(focusable)) for role, name, node in nodes]
print(json.dumps(rows))
the("toggle button", "Pause").do_action(0)
the("slider", "Stiffness").set_current_value(5000.0)
