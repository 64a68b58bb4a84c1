"""Chromium for tests of pages: how it is started, and its developer tools over a pipe."""
import json
import os
import shutil
import subprocess
import time


def browser(folder, scheme, *options):
    return [shutil.which("chromium") or "chromium", "--headless=new", "--no-sandbox", "--disable-gpu",
            "--hide-scrollbars", f"--user-data-dir={folder}/profile", f"--blink-settings=preferredColorScheme={scheme}",
            *options]


class Pipe:
    """A browser that is told what to do through a pipe, as its developer tools tell it."""

    def __init__(self, command):
        to_read, self.to_browser = os.pipe()
        from_browser, to_write = os.pipe()

        def connect():  # the browser reads its third file and writes its fourth
            a, b = os.dup(to_read), os.dup(to_write)
            os.dup2(a, 3)
            os.dup2(b, 4)

        self.process = subprocess.Popen(command, preexec_fn=connect, close_fds=False, stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(to_write)
        self.answers, self.count, self.session = os.fdopen(from_browser, "rb"), 0, None

    def ask(self, method, **parameters):
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to_browser, json.dumps(message).encode() + b"\0")
        while True:
            answer = b""
            while not answer.endswith(b"\0"):
                byte = self.answers.read(1)
                if not byte:
                    raise EOFError("the browser has ended")
                answer += byte
            answer = json.loads(answer[:-1])
            if answer.get("id") == self.count:
                return answer.get("result", {})

    def open(self, file):
        target = self.ask("Target.createTarget", url=file.as_uri())["targetId"]
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        time.sleep(1)

    def value(self, expression):
        return self.ask("Runtime.evaluate", expression=expression)["result"].get("value")

    def press(self, key, code, modifiers=0):
        for kind in ("keyDown", "keyUp"):
            self.ask("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code, modifiers=modifiers)

    def close(self):
        self.process.terminate()
        self.process.wait()
