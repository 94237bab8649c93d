"""The server answers its own page on this machine only, and keeps what comes to it within bounds."""

import http.client
import io
import json
import shlex
import stat
import time
import zipfile
from pathlib import Path
from urllib.parse import parse_qs, quote, urlsplit

import numpy as np
import pytest
import requests
from hypothesis import given, settings
from hypothesis import strategies as st

import helmbench
from helmbench.cli import status_of
from helmbench.models.model import model_to_json
from helmbench.open import app, projects
from helmbench.open.guard import HEADERS
from helmbench.reporting import open as view

from ...seeds import SHIFT
from .conftest import HOSTILE, exchanged


def raw(client, method, path, headers, body=b""):
    """The status of a request with exactly these headers."""
    connection = http.client.HTTPConnection(urlsplit(client.base).netloc, timeout=30)
    connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders(body)
    status = connection.getresponse().status
    connection.close()
    return status


def own_headers(client):
    netloc = urlsplit(client.base).netloc
    return {"host": netloc, "authorization": client.session.headers["authorization"], "origin": client.base}


def test_it_listens_to_this_machine_only_in_a_private_folder(site):
    assert site.listener.getsockname()[0] == "127.0.0.1"
    assert stat.S_IMODE(site.projects.folder.stat().st_mode) == 0o700


@pytest.mark.parametrize(
    ("changed", "status"),
    [
        ({}, 200),
        ({"host": "evil.example"}, 421),
        ({"host": "127.0.0.1:1"}, 421),
        ({"origin": "http://evil.example"}, 403),
        ({"origin": "null"}, 403),
        ({"origin": "http://["}, 403),
        ({"origin": "http://127.0.0.1:99999999"}, 403),
        ({"origin": ""}, 403),
        ({"origin": None}, 403),
        ({"authorization": None}, 403),
        ({"authorization": "Bearer wrong"}, 403),
        ({"authorization": "Bearer \xe9"}, 403),
    ],
    ids=str,
)
def test_a_change_needs_host_origin_and_key(client, changed, status):
    headers = {name: value for name, value in (own_headers(client) | changed).items() if value is not None}
    assert raw(client, "POST", "/api/projects", headers | {"content-length": "0"}) == status


def test_another_site_may_not_read(client):
    headers = own_headers(client)
    del headers["origin"]
    assert raw(client, "GET", "/api/projects", headers) == 200
    assert raw(client, "GET", "/api/projects", headers | {"sec-fetch-site": "cross-site"}) == 403
    assert raw(client, "GET", "/api/projects", headers | {"origin": "http://evil.example"}) == 403


def test_a_link_is_exchanged_once_for_a_key_that_is_no_cookie(site):
    """Its code is in the fragment, which no browser sends; who reads it later in a list of processes gets nothing."""
    link = site.link()
    parts = urlsplit(link)
    assert parts.query == "" and "code=" in parts.fragment
    answer = exchanged(site, link)
    assert answer.status_code == 200 and answer.json()["key"] not in link and "set-cookie" not in answer.headers
    again = exchanged(site, link)
    assert again.status_code == 403 and "used already" in again.json()["error"]
    headers = {"authorization": f"Bearer {answer.json()['key']}"}
    assert requests.get(f"{site.address}/api/projects", headers=headers, timeout=30).status_code == 200


def test_neither_code_nor_cookie_is_a_key(client):
    (code,) = parse_qs(urlsplit(client.site.link()).fragment)["code"]
    key = client.session.headers["authorization"].partition(" ")[2]
    url = f"{client.base}/api/projects"
    for headers in ({"authorization": f"Bearer {code}"}, {"cookie": f"helmbench={key}; key={key}"}):
        answer = requests.get(url, headers=headers, params={"token": key, "code": code, "key": key}, timeout=30)
        assert answer.status_code == 403 and "terminal" in answer.json()["error"]


def test_a_page_gets_a_code_for_another_tab(client):
    code = client.post("/api/codes").json()["code"]
    link = f"{client.base}/#code={code}"
    assert [exchanged(client.site, link).status_code for _ in range(2)] == [200, 403]
    assert requests.post(f"{client.base}/api/codes", headers={"origin": client.base}, timeout=30).status_code == 403


def test_a_ticket_is_for_one_address_and_one_use(client):
    def ticket(path):
        return client.post(f"/api/tickets?path={quote(path)}").json()["ticket"]

    def status(path, ticket, how="get"):
        return requests.request(how, client.base + path, params={"ticket": ticket}, timeout=30).status_code

    one = ticket("/api/about")
    assert [status("/api/about", one) for _ in range(2)] == [200, 403]
    assert [status("/api/projects", other := ticket("/api/about")), status("/api/about", other)] == [403, 403]
    assert status("/api/projects", ticket("/api/projects"), "post") == 403


@pytest.mark.parametrize(
    "path", ["/", "/assets/main.js", "/assets/style.css", "/api/about", "/api/choices", "/nothing"]
)
def test_every_answer_has_the_headers_that_keep_a_page_to_itself(client, path):
    answer = client.get(path)
    assert HEADERS.items() <= {name.lower(): value for name, value in answer.headers.items()}.items()
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy and "unsafe" not in policy


def test_every_file_that_the_page_names_is_served(client):
    names = [place.name for place in Path(view.__file__).with_name("assets").iterdir() if place.suffix in app.MEDIA]
    assert len(names) == 10
    for name in ("style.css", *names):
        assert client.get(f"/assets/{name}").status_code == 200
    for name in ("../index.html", "index.html", "..%2f__init__.py", "uplot.LICENSE"):
        assert client.get(f"/assets/{name}").status_code == 404


@pytest.mark.parametrize(
    ("name", "kept"),
    [
        ("../../etc/passwd", "passwd"),
        ("C:\\logs\\bridge.csv", "bridge.csv"),
        ("..", "log"),
        ("", "log"),
        (".hidden.csv", "hidden.csv"),
        ("a\n\u202egpj.csv", "a__gpj.csv"),
        (HOSTILE, "_img src=x onerror=alert(1)_"),
        ("\U0001f6a2" * 80 + ".csv", "\U0001f6a2" * 29 + ".csv"),  # 4 bytes each
        ("a.csv\u200b", "a.csv_"),
        ("\u2067a\u200d\ufeff\u00ad\u3164\ufe0f.csv", "_a_____.csv"),
    ],
)
def test_no_name_is_a_path(client, name, kept):
    project = client.project()
    assert client.upload(project, name, b"t,r\n").json()["name"] == kept
    folder = client.site.projects.folder / project.rpartition("/")[2] / "logs"
    assert [path.name for path in folder.iterdir()] == [kept]


@settings(max_examples=100 if SHIFT else 30)
@given(st.text(max_size=200))
def test_a_safe_name_is_one_part_of_a_path_and_stays_as_it_is(name):
    safe = projects.safe_name(name)
    assert Path(safe).name == safe and 0 < len(safe.encode()) <= projects.LONGEST_NAME and not safe.startswith(".")
    assert projects.safe_name(safe) == safe


def test_uploads_of_one_name_at_the_same_time_do_not_mix(client):
    """Both have begun before either ends."""
    project, contents = client.project(), [b"a" * 300_000, b"b" * 300_000]
    connections = [http.client.HTTPConnection(urlsplit(client.base).netloc, timeout=30) for _ in contents]
    for connection, content in zip(connections, contents, strict=True):
        connection.putrequest("POST", f"{project}/logs?name=a.csv", skip_host=True, skip_accept_encoding=True)
        for name, value in (own_headers(client) | {"content-length": str(len(content))}).items():
            connection.putheader(name, value)
        connection.endheaders(content[:100_000])
    folder = client.site.projects.folder / project.rpartition("/")[2]
    while len(list((folder / projects.COMING).iterdir())) < 2:
        time.sleep(0.01)
    assert client.get(project).json()["files"] == []
    for connection, content in zip(connections, contents, strict=True):
        connection.send(content[100_000:])
    names = [json.loads(connection.getresponse().read())["name"] for connection in connections]
    for connection in connections:
        connection.close()
    assert sorted(names) == ["a-2.csv", "a.csv"]
    assert [(folder / "logs" / name).read_bytes() for name in names] == contents
    assert list((folder / projects.COMING).iterdir()) == []


def test_files_of_one_name_are_both_kept_and_can_be_taken_away(client):
    project = client.project()
    assert [client.upload(project, "a.csv", b"1").json()["name"] for _ in range(3)] == ["a.csv", "a-2.csv", "a-3.csv"]
    url = f"{client.base}{project}/logs/{quote('a-2.csv')}"
    left = client.session.delete(url, headers={"origin": client.base}, timeout=30).json()["files"]
    assert [file["name"] for file in left] == ["a.csv", "a-3.csv"]
    assert client.session.delete(url, headers={"origin": client.base}, timeout=30).status_code == 400


def test_a_file_that_is_too_large_is_refused_and_nothing_of_it_stays(client, monkeypatch):
    project = client.project()
    headers = own_headers(client) | {"content-length": str(app.MOST_BYTES + 1)}
    assert raw(client, "POST", f"{project}/logs?name=a.csv", headers) == 413
    monkeypatch.setattr(app, "MOST_BYTES", 1000)
    chunks = iter([b"x" * 600, b"x" * 600])  # without a length that is told before
    assert client.upload(project, "a.csv", chunks).status_code == 413
    folder = client.site.projects.folder / project.rpartition("/")[2] / "logs"
    assert list(folder.iterdir()) == [] == list((folder.parent / projects.COMING).iterdir())


def test_a_file_that_does_not_come_whole_is_not_kept(client):
    project = client.project()
    connection = http.client.HTTPConnection(urlsplit(client.base).netloc, timeout=30)
    connection.putrequest("POST", f"{project}/logs?name=a.csv", skip_host=True, skip_accept_encoding=True)
    for name, value in (own_headers(client) | {"content-length": "1000"}).items():
        connection.putheader(name, value)
    connection.endheaders(b"half")
    connection.close()
    assert client.upload(project, "b.csv", b"1").status_code == 200
    assert [file["name"] for file in client.get(project).json()["files"]] == ["b.csv"]


@pytest.mark.parametrize(
    ("path", "content", "said"),
    [
        ("read", {}, "no log to read"),
        ("read", {"positive_rudder": "left"}, "positive_rudder"),
        ("read", {"choices": [["a", "b", {"to": "heading", "sign": 2}]]}, "sign"),
        ("parts", {"parts": [{"record": 0, "name": "a", "from": 0, "to": 1, "role": "train"}]}, "there is not"),
        ("parts", {"folder": "/etc"}, "malformed"),
        ("analyses", {"kind": "check"}, "no record yet"),
        ("analyses", {"kind": "identify", "model": "auto", "method": "mine.py:Method"}, "unknown method"),
        ("analyses", {"kind": "diagnose", "model": "/etc/passwd"}, "unknown model"),
        ("analyses", {"kind": "diagnose", "model": "file:../../x"}, "no record yet"),
        ("analyses", {"kind": "format"}, "kind"),
    ],
    ids=str,
)
def test_what_cannot_be_is_refused_in_one_line(client, path, content, said):
    answer = client.post(f"{client.project()}/{path}", content)
    assert answer.status_code == 400
    line = answer.json()["error"]
    assert said in line and "\n" not in line


def test_unknown_projects_results_and_files_are_refused(client):
    assert client.get("/api/projects/nothing").status_code == 400
    assert client.get("/api/projects/..%2f..").status_code == 404
    project = client.project()
    assert client.get(f"{project}/analyses/1").status_code == 400
    assert client.get(f"{project}/columns").status_code == 404


def test_a_body_that_is_too_large_is_refused(client, monkeypatch):
    monkeypatch.setattr(app, "MOST_BODY", 100)
    assert client.post(f"{client.project()}/parts", {"parts": ["x" * 200]}).status_code == 413


# ------------------------------------------------------------------------------------------------ from log to answer


@pytest.fixture(scope="module")
def read(client, log):
    """A project whose log has been read."""
    project = client.project()
    client.upload(project, "bridge.csv", log)
    assert client.post(f"{project}/read", {"choices": [], "positive_rudder": None}).status_code == 200
    return project, client.finished(project)


def test_a_log_becomes_records_with_every_column_told_and_drawn(client, read):
    project, state = read
    columns = {one["column"]: one for one in state["log"]["columns"]}
    assert columns["ROT"]["quantity"] == "yaw_rate" and columns[HOSTILE]["quantity"] == "not used"
    assert all(one["why"] for one in columns.values())
    drawn = client.get(f"{project}/columns").json()
    assert {one["column"] for one in drawn} == set(columns) and all(len(one["values"]) <= 300 for one in drawn)
    roles = [part["role"] for part in state["parts"]]
    assert roles == ["train", "held_out"] and state["parts"][0]["to"] < state["parts"][1]["from"]
    tracks = {one["label"]: one for one in client.get(f"{project}/records/0").json()["tracks"]}
    ends = {label: (one["north"][-1], one["east"][-1]) for label, one in tracks.items()}
    assert ends["speed and heading"] == pytest.approx(ends["positions"], abs=20.0)


def test_a_mirrored_or_too_large_channel_is_seen(client, read):
    """The heading by the yaw rate leaves the recorded one when its sign is turned; deg/min as deg/s makes no record,
    and costs no part."""
    project, state = read

    def after(**said):
        choices = [["bridge.csv", "ROT", {"to": "yaw_rate", **said}]]
        client.post(f"{project}/read", {"choices": choices, "positive_rudder": None})
        return client.finished(project)

    def furthest(**said):
        assert after(**said)["log"]["line"] == ""
        both = client.get(f"{project}/records/0").json()["headings"]
        return max(abs(a - b) for a, b in zip(both["heading"], both["yaw_rate"], strict=True))

    biased = furthest(unit="deg/min")
    assert biased == pytest.approx(0.229 * 400.0, rel=0.05)
    assert furthest(unit="deg/min", sign=-1) != pytest.approx(biased, rel=0.1)
    refused = after(unit="deg/s")
    assert "check the units" in refused["log"]["line"] and refused["log"]["records"] == []
    assert refused["parts"] == state["parts"]
    again = client.post(f"{project}/read", {"choices": [], "positive_rudder": None})
    assert again.status_code == 200 and client.finished(project)["parts"] == state["parts"]


@pytest.mark.nightly
def test_readings_do_not_pile_up(client, read):
    """What is replaced, refused or cancelled goes; what an answer was made from stays as long as it is the last."""
    project, _ = read
    folder = client.site.projects.folder / project.rpartition("/")[2]
    for choices in ([], [["bridge.csv", "ROT", {"to": "yaw_rate", "unit": "kn"}]], []):
        client.post(f"{project}/read", {"choices": choices})
        state = client.finished(project)
    client.post(f"{project}/read", {})
    client.post(f"{project}/cancel")
    assert client.post(f"{project}/analyses", {"kind": "check"}).status_code == 200
    assert [path.name for path in folder.glob("reading-*")] == [state["reading"]]
    client.post(f"{project}/cancel")


def test_a_choice_that_cannot_be_is_told_and_nothing_is_lost(client, read):
    project, state = read
    client.post(f"{project}/read", {"choices": [["bridge.csv", "ROT", {"to": "yaw_rate", "unit": "kn"}]]})
    after = client.finished(project)
    assert after["job"]["state"] == "refused" and "needs a unit of yaw_rate" in after["job"]["message"]
    assert after["log"] == state["log"]


def test_a_check_finds_the_bias_and_gives_its_files(client, read, log, tmp_path, monkeypatch):
    project, state = read
    assert client.post(f"{project}/parts", {"parts": state["parts"]}).status_code == 200
    assert client.post(f"{project}/analyses", {"kind": "check"}).status_code == 200
    after = client.finished(project)
    assert after["job"]["state"] == "done", after["job"]["message"]
    (answer,) = after["analyses"]
    assert answer["sentence"].startswith("2 records: ") and "yaw rate bias" in answer["sentence"]
    view = client.get(f"{project}/analyses/{answer['id']}").json()
    findings = next(part for part in view["parts"] if part["title"] == "What matters")
    assert "yaw rate bias" in [row[0] for row in findings["blocks"][0]["rows"]] and view["tone"] == "fair"
    place = f"{project}/analyses/{answer['id']}/files"
    page = client.get(f"{place}/check.html")
    assert page.headers["content-security-policy"].startswith("sandbox") and "yaw rate bias" in page.text
    assert client.get(f"{place}/view.json").status_code == 404
    assert client.get(f"{place}/..%2f..%2flogs%2fbridge.csv").status_code == 404
    with zipfile.ZipFile(io.BytesIO(client.get(f"{project}/analyses/{answer['id']}/all.zip").content)) as archive:
        assert set(archive.namelist()) == set(answer["files"]) >= {"log.map.yaml", "notebook.ipynb", "commands.sh"}
        archive.extractall(tmp_path)
    (tmp_path / "bridge.csv").write_bytes(log)
    monkeypatch.chdir(tmp_path)
    names = {}
    for cell in json.loads((tmp_path / "notebook.ipynb").read_text("utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            exec(cell["source"], names)
    assert names["found"].to_json() == json.loads((tmp_path / "check.json").read_text("utf-8"))
    lines = (tmp_path / "commands.sh").read_text("utf-8").splitlines()
    commands = [shlex.split(line)[1:] for line in lines if line.startswith("helmbench ")]
    assert [words[0] for words in commands] == ["import", "check"]
    assert [status_of(words) for words in commands] == [0, 1]  # the bias matters


def test_no_answer_names_the_private_folder(client, read, tmp_path):
    """With a model that was dropped: neither files nor state nor a refusal; the stages are as many as told."""
    project, state = read
    folder = str(client.site.projects.folder)
    model_to_json(helmbench.resolve("mariner"), tmp_path / "own.json")
    client.upload(project, "own.json", (tmp_path / "own.json").read_bytes())
    client.post(f"{project}/parts", {"parts": state["parts"]})
    assert client.post(f"{project}/analyses", {"kind": "diagnose", "model": "file:own.json"}).status_code == 200
    after = client.finished(project)
    assert after["job"]["state"] == "done" and 4 < len(after["job"]["stages"]) <= after["job"]["steps"]
    archive = client.get(f"{project}/analyses/{after['analyses'][0]['id']}/all.zip").content
    with zipfile.ZipFile(io.BytesIO(archive)) as files:
        assert [name for name in files.namelist() if folder.encode() in files.read(name)] == []
    view = client.get(f"{project}/analyses/{after['analyses'][0]['id']}").text
    client.upload(project, "broken.json", b'{"family": "nomoto-1", "coefficients": {}}')
    client.post(f"{project}/analyses", {"kind": "diagnose", "model": "file:broken.json"})
    refused = client.finished(project)["job"]
    assert refused["state"] == "refused" and refused["message"].startswith("broken.json")
    assert folder not in json.dumps([refused, after, view])


def test_the_question_is_remembered(client):
    project, asked = client.project(), {"kind": "identify", "model": "nomoto-1", "method": "ls"}
    assert client.post(f"{project}/question", asked).status_code == 200
    assert client.get(project).json()["question"] == asked
    assert client.post(f"{project}/question", {"kind": "format"}).status_code == 400


def test_a_job_is_cancelled_at_once_and_projects_do_not_disturb_each_other(client, read, log):
    project, state = read
    before = len(client.get(project).json()["analyses"])
    other = client.project()
    client.upload(other, "other.csv", log)
    client.post(f"{project}/analyses", {"kind": "identify", "model": "auto"})
    client.post(f"{other}/read", {})
    assert client.post(f"{project}/cancel").json()["job"]["state"] == "cancelled"
    assert client.finished(other)["log"]["records"]
    after = client.get(project).json()
    assert len(after["analyses"]) == before and after["parts"] == state["parts"]
    listed = [one["id"] for one in client.get("/api/projects").json()]
    assert {project.rpartition("/")[2], other.rpartition("/")[2]} <= set(listed)


@pytest.mark.nightly
def test_what_no_one_states_is_asked_and_answered(client, recorded):
    """Columns without units: every answer is taken, also one to a question that an answer opened; a wrong unit is told
    and can be changed."""
    columns = {
        "Time": recorded.time_s,
        "Kurs": np.degrees(recorded.heading_unwrapped()) % 360.0,
        "Drehrate": recorded.column("yaw_rate_rad_s"),
        "Ruder": np.degrees(recorded.rudder()),
    }
    rows = [";".join(f"{value:.6f}" for value in row) for row in zip(*columns.values(), strict=True)]
    project = client.project()
    client.upload(project, "log.csv", "\n".join([";".join(columns), *rows]).encode())
    wanted = ["heading", "deg", "rad/s"]
    answers = {}
    client.post(f"{project}/read", {})
    while asked := [q for one in client.finished(project)["log"]["columns"] for q in one["questions"]]:
        assert asked[0]["id"] not in answers
        keys = [answer["key"] for answer in asked[0]["answers"]]
        answers[asked[0]["id"]] = next(key for key in [*wanted, keys[0]] if key in keys)
        client.post(f"{project}/read", {"answers": answers})
    state = client.get(project).json()
    assert answers and state["log"]["line"] == "" and state["log"]["records"]
    wrong = [["log.csv", "Drehrate", {"to": "yaw_rate", "unit": "deg/s"}]]
    client.post(f"{project}/read", {"answers": answers, "choices": wrong})
    assert "check the units" in client.finished(project)["log"]["line"]
    client.post(f"{project}/read", {"answers": answers})
    assert client.finished(project)["log"]["records"] == state["log"]["records"]


def test_a_sidecar_and_a_mapping_go_with_their_log_and_json_is_a_model_by_what_it_holds(client, recorded, tmp_path):
    """The sidecar says on which side a positive rudder turns the ship; the mapping leaves a column out."""
    helmbench.write_record(recorded, tmp_path / "run.csv")
    project = client.project()
    for name in ("run.yaml", "run.csv"):
        assert client.upload(project, name, (tmp_path / name).read_bytes()).json()["kind"] == "logs"
    client.post(f"{project}/read", {})
    state = client.finished(project)
    assert [(one["name"], one["beside"]) for one in state["files"]] == [("run.yaml", True), ("run.csv", False)]
    assert state["log"]["line"] == "" and state["log"]["records"][0]["positive_rudder"] == "port"
    assert any("run.yaml" in one["why"] for one in state["log"]["columns"])
    mapping = helmbench.draft_import(tmp_path / "run.csv")
    mapping = mapping.with_columns({("run.csv", "yaw_rate_rad_s"): {"to": "not used"}})
    mapping.write_mapping(tmp_path / "run.map.yaml")
    client.upload(project, "run.map.yaml", (tmp_path / "run.map.yaml").read_bytes())
    client.post(f"{project}/read", {})
    assert "yaw_rate_rad_s" not in client.finished(project)["log"]["records"][0]["channels"]
    assert client.upload(project, "log.json", b'[{"Time": 0}]').json()["kind"] == "logs"


def test_a_time_that_was_misread_is_said_in_its_column(client):
    project = client.project()
    time = np.arange(0.0, 100.0, 0.5)
    rows = [f"{t:.1f},{t:.1f},{20 * np.sin(t / 9):.4f},{10 * np.cos(t / 9):.4f}" for t in time]
    client.upload(project, "log.csv", "\n".join(["Time [s],Other,Heading [deg],Rudder [deg]", *rows]).encode())
    forms = client.get("/api/about").json()["quantities"]["time"]
    assert {"seconds", "minutes", "iso", "clock"} <= set(forms) and "rows" not in forms

    for column, form, last_s in (("Time", "minutes", 5970.0), ("Other", "seconds", 99.5)):
        said = {"choices": [["log.csv", column, {"to": "time", "unit": form}]], "positive_rudder": "starboard"}
        client.post(f"{project}/read", said)
        log = client.finished(project)["log"]
        assert [(one["column"], one["unit"]) for one in log["columns"] if one["quantity"] == "time"] == [(column, form)]
        assert log["records"][0]["to"] == pytest.approx(last_s)


def test_an_answer_is_kept_in_words(client, tmp_path):
    project = client.project()
    time = np.arange(0.0, 100.0, 0.5)
    rows = [f"{t};{20 * np.sin(t / 9):.4f};{np.cos(t / 9):.4f}" for t in time]
    client.upload(project, "log.csv", "\n".join(["Time [s];Kurs;Ruder [deg]", *rows]).encode())
    client.post(f"{project}/read", {})
    question = client.finished(project)["log"]["questions"][0]
    answer = question["answers"][0]
    client.post(f"{project}/read", {"answers": {question["id"]: answer["key"]}})
    state = client.finished(project)
    assert state["answered"] == [{"id": question["id"], "text": question["text"], "answer": answer["text"]}]
    assert question["id"] not in {one["id"] for one in state["log"]["questions"]}


def test_there_is_an_example_to_start_from(client):
    project = client.project()
    assert client.post(f"{project}/example").status_code == 200
    state = client.finished(project)
    assert [one["name"] for one in state["files"] if not one["beside"]] == ["example.csv"]
    assert state["log"]["line"] == "" and [part["role"] for part in state["parts"]] == ["train", "held_out"]
