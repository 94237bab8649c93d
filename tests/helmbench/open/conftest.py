"""A server of `helmbench open` in this process, and logs to drop."""

import threading
import time
from dataclasses import dataclass
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
import requests

import helmbench
from helmbench.open import serve

from ...datasets.importing.raw_logs import bridge

TIME = np.arange(0.0, 240.0, 0.5)
HOSTILE = "<img src=x onerror=alert(1)>"


@dataclass
class Client:
    """Speaks to a server as its page does."""

    site: serve.Site
    session: requests.Session

    @property
    def base(self):
        return self.site.address

    def get(self, path):
        return self.session.get(self.base + path, timeout=30)

    def post(self, path, content=None, **more):
        return self.session.post(self.base + path, json=content, headers={"origin": self.base}, timeout=30, **more)

    def project(self):
        return f"/api/projects/{self.post('/api/projects').json()['id']}"

    def upload(self, project, name, data):
        headers = {"origin": self.base}
        return self.session.post(
            f"{self.base}{project}/logs", params={"name": name}, data=data, headers=headers, timeout=30
        )

    def finished(self, project, seconds=120.0):
        """The state of a project when its job has ended."""
        end = time.monotonic() + seconds
        while (state := self.get(project).json())["job"]["state"] in ("waiting", "running"):
            assert time.monotonic() < end, state["job"]
            time.sleep(0.05)
        return state


def exchanged(site, link):
    """The answer to a page that brings a link's code."""
    (code,) = parse_qs(urlsplit(link).fragment)["code"]
    headers = {"origin": site.address, "authorization": f"Bearer {code}"}
    return requests.post(f"{site.address}/api/key", headers=headers, timeout=30)


@pytest.fixture(scope="module")
def site():
    with serve.site() as made:
        server = made.server()
        thread = threading.Thread(target=server.run, kwargs={"sockets": [made.listener]})
        thread.start()
        yield made
        server.should_exit = True
        thread.join()


@pytest.fixture(scope="module")
def client(site):
    with requests.Session() as session:
        key = exchanged(site, site.link()).json()["key"]
        session.headers["authorization"] = f"Bearer {key}"
        yield Client(site, session)


@pytest.fixture(scope="module")
def recorded():
    """A zigzag of a ship whose turn sensor has a bias of 0.004 rad/s."""
    record = helmbench.simulate("mariner", "zigzag:20/20", noise="low", seed=1)
    return record.with_channels(yaw_rate_rad_s=record.column("yaw_rate_rad_s") + 0.004)


@pytest.fixture(scope="module")
def log(recorded, tmp_path_factory):
    """What the bridge logged of it, with names and cells that a page must not take for markup."""
    (path,) = bridge(recorded, tmp_path_factory.mktemp("log"))
    return path.read_text("utf-8").replace("Remark", HOSTILE, 1).replace("pilot aboard", HOSTILE, 1).encode()


def swing(time=TIME):
    """Heading, deg, yaw rate, deg/s, and rudder, deg, of a first-order ship in a zigzag."""
    rudder = np.clip(40.0 * np.sin(time / 12.0), -20.0, 20.0)
    rate = np.zeros_like(time)
    for i in range(1, time.size):
        rate[i] = rate[i - 1] + (time[i] - time[i - 1]) * (0.05 * rudder[i - 1] - rate[i - 1]) / 8.0
    return np.cumsum(rate) * (time[1] - time[0]), rate, rudder
