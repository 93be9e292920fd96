# SPDX-License-Identifier: GPL-3.0-only
"""MeshLab's GUI, started under Xvfb in a private home and driven from within by gui_agent.cpp.

    agent = "build/meshlab-2020.09/tests/libgui_agent.so"
    with MeshLab(binary, home=tmp_path, files=["a.ply"], agent=agent) as gui:
        gui.apply("Spherical parameterise root", Initial_map="Harmonic")
        assert "0 flipped" in gui.log()
        gui.picture("root")

Works with every MeshLab that uses Qt 5 (2020.09, 2025.07). Everything is found as the user finds
it, by what is written on it, and waited for: nothing depends on the speed of the machine. Needs
Xvfb and Mesa's software OpenGL.
"""

import json
import os
import re
import socket
import subprocess
import tempfile
import time
from pathlib import Path

# Seconds until something is given up; nothing is asserted about time.
PATIENCE = int(os.environ.get("GUI_PATIENCE", "300"))

# What keeps the first-run dialogs and the network calls of both versions away.
SETTINGS = """[General]
informativeShown=true
lastTimeMeshLabVersionCheckedOnStart=Fri Jan 1 2100
dontRemindMeToSendEmail=true
MeshLab%3A%3ASystem%3A%3AcheckForUpdate="<!DOCTYPE MeshLabSettings>\\n\
<Param type=\\"RichBool\\" value=\\"false\\" \
name=\\"MeshLab::System::checkForUpdate\\" description=\\"\\" tooltip=\\"\\"/>\\n"
MeshLab%3A%3ASystem%3A%3AsendAnonymousData="<!DOCTYPE MeshLabSettings>\\n\
<Param type=\\"RichBool\\" value=\\"false\\" \
name=\\"MeshLab::System::sendAnonymousData\\" description=\\"\\" tooltip=\\"\\"/>\\n"
"""


# The filters as the plugins' help calls them, and those that have a dialog.
_HELP = [f.read_text() for f in sorted(Path(__file__).parents[2].glob("filter_*/help/*.html"))]
_TITLES = {text: re.search("<title>(.*)</title>", text) for text in _HELP}
FILTERS = [title.group(1) for title in _TITLES.values() if title]
# What makes the first layers, in an empty project too.
CREATING = ["Beating ventricle phantom", "Import label volume as layers"]
FILTERS_WITH_DIALOG = [t.group(1) for text, t in _TITLES.items() if t and "<dl>" in text]


class GuiError(Exception):
    """The GUI did not do what it was asked for."""


def until(condition, what, patience=PATIENCE):
    """Calls condition() until it returns something true, and returns that."""
    end = time.monotonic() + patience
    while True:
        result = condition()
        if result:
            return result
        if time.monotonic() > end:
            raise GuiError(f"waited {patience} s for {what}")
        time.sleep(0.1)


class MeshLab:
    """A running MeshLab.

    binary: meshlab's executable; files: meshes and projects to open; home: a folder of its own for
    settings and user plugins;
    agent: the library built from gui_agent.cpp; pictures: where picture() writes; environment: more
    variables; screen: its size.
    """

    def __init__(
        self, binary, home, agent, files=(), pictures=None, environment=None, screen=(1280, 768)
    ):
        self.binary, self.home, self.agent = Path(binary), Path(home), Path(agent)
        self.files, self.pictures = [str(Path(f).resolve()) for f in files], Path(pictures or home)
        self.more, self.screen = environment or {}, screen
        # Short: a socket's path has at most 107 characters.
        self._folder = tempfile.TemporaryDirectory(prefix="gui-")
        self._processes, self._socket, self._received = [], None, b""
        self._filter = None  # whose dialog was opened last

    def __enter__(self):
        try:
            self._start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        if self._socket:
            self._socket.close()
        for process in reversed(self._processes):
            process.kill()
            process.wait()
        self._folder.cleanup()

    def _start(self):
        for folder in ("config/VCG", "data", "run"):
            (self.home / folder).mkdir(parents=True, exist_ok=True)
        (self.home / "run").chmod(0o700)
        for name in ("MeshLab_64bit_fp.conf", "MeshLab_64bit.conf"):
            (self.home / "config/VCG" / name).write_text(SETTINGS)
        self.pictures.mkdir(parents=True, exist_ok=True)

        reading, writing = os.pipe()
        with (self.home / "xvfb.log").open("w") as log:
            self._processes.append(
                subprocess.Popen(
                    [
                        "Xvfb",
                        "-displayfd",
                        str(writing),
                        "-screen",
                        "0",
                        "{}x{}x24".format(*self.screen),
                        "+extension",
                        "GLX",
                        "-nolisten",
                        "tcp",
                    ],
                    pass_fds=[writing],
                    stdout=log,
                    stderr=log,
                )
            )
        os.close(writing)
        with os.fdopen(reading) as answer:
            display = answer.readline().strip()
        if not display:
            raise GuiError("Xvfb did not start: " + (self.home / "xvfb.log").read_text())

        path = Path(self._folder.name) / "agent"
        environment = {
            k: v for k, v in os.environ.items() if not k.startswith(("QT_", "XDG_", "WAYLAND"))
        }
        environment.update(
            HOME=str(self.home),
            XDG_CONFIG_HOME=str(self.home / "config"),
            XDG_DATA_HOME=str(self.home / "data"),
            XDG_RUNTIME_DIR=str(self.home / "run"),
            DISPLAY=":" + display,
            LC_ALL="C.UTF-8",
            LIBGL_ALWAYS_SOFTWARE="1",
            LD_PRELOAD=str(self.agent),
            GUI_AGENT_SOCKET=str(path),
            **self.more,
        )
        with (self.home / "meshlab.log").open("w") as log:
            self.process = subprocess.Popen(
                [str(self.binary), *self.files], env=environment, stdout=log, stderr=log
            )
        self._processes.append(self.process)

        def connected():
            self._check_alive()
            connection = socket.socket(socket.AF_UNIX)
            try:
                connection.connect(str(path))
            except OSError:
                connection.close()
                return None
            connection.settimeout(PATIENCE)
            return connection

        self._socket = until(connected, "MeshLab to start")
        until(lambda: any(w["class"] == "MainWindow" for w in self.widgets()), "MeshLab's window")

    # ------------------------------------------------------------ asking

    def alive(self):
        return self.process.poll() is None

    def output(self):
        """What MeshLab has printed."""
        return (self.home / "meshlab.log").read_text(errors="replace")

    def _check_alive(self):
        if not self.alive():
            raise GuiError(
                f"MeshLab has ended (exit code {self.process.returncode}):\n{self.output()[-2000:]}"
            )

    def ask(self, do, **arguments):
        """Sends a command of gui_agent.cpp; returns its answer. Throws GuiError when it says that
        it could not."""
        try:
            self._socket.sendall(json.dumps({"do": do, **arguments}).encode() + b"\n")
            while b"\n" not in self._received:
                received = self._socket.recv(1 << 20)
                if not received:
                    raise ConnectionError
                self._received += received
        except OSError as error:
            self.process.wait(PATIENCE) if isinstance(error, ConnectionError) else None
            self._check_alive()
            raise GuiError(f"MeshLab does not answer: {do} {arguments}") from error
        line, self._received = self._received.split(b"\n", 1)
        answer = json.loads(line)
        if "error" in answer:
            raise GuiError(f"{do} {arguments}: {answer['error']}")
        return answer

    def widgets(self):
        """The visible widgets, from top to bottom: list of {class, text, tooltip, enabled, window,
        place (x, y, width, height), ...}."""
        return self.ask("widgets")["widgets"]

    def menus(self):
        """All menu entries: list of {menu, text, enabled, tooltip}."""
        return self.ask("menus")["entries"]

    def log(self):
        """The lines of MeshLab's log window, as one text."""
        return "\n".join(self.ask("lists")["lines"])

    def layers(self):
        """The labels in the layer dialog, in layer order."""
        rows = self.ask("lists")["rows"]
        return [row[2] for row in rows if len(row) > 2 and row[1].isdigit()]

    def picture(self, name, of_dialog=False):
        """Writes a picture of the screen, or of the filter's dialog alone; returns its path."""
        file = self.pictures / f"{name}.png"
        part = []
        if of_dialog:
            inside = [w["place"] for w in self.widgets() if w["window"] == self._filter]
            part = max(inside, key=lambda place: place[2] * place[3])
        self.ask("picture", file=str(file), part=part)
        return file

    def message(self):
        """The text of the message box that is open, or None."""
        widgets = self.widgets()
        if not any(w["class"] == "QMessageBox" for w in widgets):
            return None
        title = next(w["text"] for w in widgets if w["class"] == "QMessageBox")
        return " ".join(
            w["text"]
            for w in widgets
            if w["class"] == "QLabel" and w["window"] == title and w["text"]
        )

    # ------------------------------------------------------------ acting

    def trigger(self, text):
        """Chooses a menu entry."""
        self.ask("trigger", text=text)

    def click(self, text, **more):
        self.ask("click", **{"class": "QAbstractButton", "text": text, **more})

    def fill_screen(self):
        """Makes the window as large as the screen; there is no window manager to do it."""
        self.ask("fill screen")

    def choose_layer(self, label):
        """Makes a layer the current one, in the layer dialog."""
        self.ask("click cell", text=label)

    def open_filter(self, name):
        """Chooses a filter in the menu and waits for its dialog, which start(), set() and
        close_dialog() then mean."""
        self.trigger(name)
        until(lambda: self._has_dialog(name), f"the dialog of {name}")
        self._filter = name

    def button_off_screen(self, text="Apply"):
        """How many pixels of a button of the filter's dialog lie off the screen; 0: all of it is
        seen."""
        x, y, width, height = next(
            w["place"]
            for w in self.widgets()
            if w["text"] == text and w["window"] == self._filter and "Button" in w["class"]
        )
        wide, high = self.screen
        return max(-x, -y, x + width - wide, y + height - high, 0)

    def hidden_below_buttons(self, button="Default"):
        """The texts of the filter's dialog that reach below the upper edge of its buttons."""
        shown = [w for w in self.widgets() if w["window"] == self._filter]
        top = next(w["place"][1] for w in shown if w["text"] == button)
        return [
            w["text"]
            for w in shown
            if w["class"] in ("QCheckBox", "QLabel", "QLineEdit", "QComboBox")
            and w["place"][1] < top < w["place"][1] + w["place"][3]
        ]

    def clipped_texts(self):
        """The texts of the filter's dialog whose last lines have no room."""
        return [
            w["text"] for w in self.widgets() if w["window"] == self._filter and w.get("clipped")
        ]

    def _has_dialog(self, name):
        return any(
            w["text"] == "Apply" and w["window"] == name and w["enabled"] for w in self.widgets()
        )

    def start(self):
        """Presses Apply."""
        self.click("Apply", window=self._filter)

    def close_dialog(self):
        """Presses Close in the filter's dialog."""
        self.click("Close", window=self._filter)
        until(lambda: not self._has_dialog(self._filter), "the dialog to close")

    def wait_for_end(self, log_before):
        """Waits until a filter has ended; returns the text of the message box when it failed, else
        None.

        log_before: log() before it was started.
        """
        applied = log_before.count("Applied filter")

        def ended():
            self._check_alive()
            message = self.message()
            return (
                (message,)
                if message
                else (None,)
                if self.log().count("Applied filter") > applied
                else None
            )

        return until(ended, "the filter to end")[0]

    def set(self, label, value):
        """Fills in the field beside a label of the filter's dialog: text, an entry of a choice, or
        True and False."""
        try:
            self.ask("set", label=label, window=self._filter, value=value)
        except GuiError:  # a check box bears its label itself
            self.ask(
                "set",
                **{"class": "QCheckBox", "text": label, "window": self._filter, "value": value},
            )

    def apply(self, name, **fields):
        """Opens a filter, fills in fields (their labels, with _ for blanks), presses Apply, waits
        until it has finished.

        Returns the lines that it added to the log. Throws GuiError with MeshLab's message when the
        filter failed.
        """
        self.open_filter(name)
        for label, value in fields.items():
            self.set(label.replace("_", " "), value)
        return self._finished(self.start)

    def run(self, name):
        """The same for a filter without parameters, which has no dialog."""
        return self._finished(lambda: self.trigger(name))

    def _finished(self, start):
        before = self.log()
        start()
        message = self.wait_for_end(before)
        if message:
            raise GuiError(message)
        return self.log()[len(before) :].strip()

    def close_message(self):
        """Presses OK in the message box."""
        self.click("OK")
        until(lambda: self.message() is None, "the message box to close")

    def save_project(self, path):
        """File, Save Project, with all its files. Where MeshLab asks (2020.09), new layers get
        "layer 0.ply", ... beside it."""
        path, new, before = Path(path), 0, len(self.log())
        title = next(w["text"] for w in self.widgets() if w["class"] == "MainWindow")
        self.trigger(next(e["text"] for e in self.menus() if e["text"].startswith("Save Project")))

        # 2020.09 writes the project first, then its layers, each with a line in the log
        def all_written():
            saved = {
                line.split(" in ")[0]
                for line in self.log()[before:].splitlines()
                if line.startswith("Saved Mesh")
            }
            return (
                path.exists()
                and ("2020.09" not in title or len(saved) == len(self.layers()))
                and "all"
            )

        while True:
            dialog = until(
                lambda: self._dialog() or all_written(), f"{path} and its layers to be written"
            )
            if dialog == "all":
                return
            if dialog["class"] == "SaveMaskExporterDialog":
                self.click("OK", window=dialog["text"])
                answer = {}
            elif "Project" in dialog["text"]:
                self.ask("set", **{"class": "QCheckBox", "text": "Save All Files", "value": True})
                answer = {"file": str(path)}
            else:
                answer = {"file": str(path.parent / f"layer {new}.ply")}
                new += 1
            until(
                lambda shown=dialog, answer=answer: self._answered(shown, answer),
                f"the dialog {dialog['text']} to close",
            )

    def _answered(self, shown, answer):
        """Whether a dialog has gone. Says the answer again while it stands there, since a file
        dialog takes none before it has read its folder."""
        if self.message():
            raise GuiError(f"{shown['text']}: {self.message()}")
        if self._dialog() != shown:
            return True
        if answer:
            try:
                self.ask("choose file", title=shown["text"], **answer)
            except GuiError:  # it has gone since, or MeshLab has
                self._check_alive()
        return False

    def _dialog(self):
        """The file dialog or save mask dialog that is open."""
        return next(
            (w for w in self.widgets() if w["class"] in ("QFileDialog", "SaveMaskExporterDialog")),
            None,
        )
