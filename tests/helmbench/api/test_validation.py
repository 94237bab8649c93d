"""Validation from Python: what is taken, and the outcome's table, figure, page and files."""

import json

import pytest

import helmbench


@pytest.fixture(scope="module")
def record():
    return helmbench.simulate("response-1", "zigzag:20/20", noise="low", seed=3)


@pytest.fixture(scope="module")
def found(record):
    return helmbench.validate("response-1", record, compare=["response-2"])


def test_the_outcome_shows_itself(found, record):
    score = found.score(None)
    assert repr(found).startswith(f"<Validation on 1 records, free runs: response-1 R2 {score.r2:.3f}, response-2 R2 ")
    assert found._repr_html_().startswith("<p><b>Validation of response-1, response-2: ")
    frame = found.to_dataframe()
    assert list(frame.columns) == ["model", "record", "channel", "horizon", "horizon_s", "n", "rmse", "r2"]
    own = frame[(frame.model == "response-2") & (frame.channel == "heading_rad") & frame.record.isna()]
    assert len(own) == 2 + len(found.horizons_s)
    figure = found.plot()
    assert len(figure.axes) == 2 and len(figure.axes[0].lines) == 3
    with pytest.raises(helmbench.BadInput, match="no such record"):
        found.plot("another")


def test_models_and_records_of_any_kind_are_taken(record, tmp_path):
    estimate = helmbench.identify(record, "nomoto-1", "ls")
    first, second, third = (
        helmbench.simulate("response-1", "zigzag:20/20", noise="low", seed=seed) for seed in (4, 5, 6)
    )
    for written, folder in ((first, "a"), (second, "b")):
        (tmp_path / folder).mkdir()
        helmbench.write_record(written, tmp_path / folder / "run.csv")
        estimate.save(tmp_path / folder / "model.json")
    paths = [tmp_path / folder / "run.csv" for folder in ("a", "b")]
    models = [tmp_path / folder / "model.json" for folder in ("a", "b")]
    found = helmbench.validate(models[0], [*paths, record, third], compare=[models[1], estimate.model])
    assert list(found.models)[:2] == [str(path) for path in models]
    names = [one.name for one in found.records]
    assert names == [str(paths[0]), str(paths[1]), record.name, f"{record.name} (2)"]
    for name in names:
        rmse = {found.score("heading_rad", model, name).rmse for model in found.models}
        assert max(rmse) == pytest.approx(min(rmse), rel=1e-6)


def test_a_record_given_twice_is_refused(record):
    with pytest.raises(helmbench.BadInput, match="same samples"):
        helmbench.validate("response-1", [record, record])


def test_an_extended_model_is_validated_in_the_recorded_channels(record):
    from dataclasses import replace

    base = helmbench.resolve("response-1")
    biased = record.with_channels(yaw_rate_rad_s=record.column("yaw_rate_rad_s") + 0.01)
    extended = replace(base, id="extended", instruments={"yaw_rate_bias": 0.01})
    found = helmbench.validate(base, biased, compare=extended)
    errors = [found.score("yaw_rate_rad_s", name).rmse for name in found.models]
    assert errors[1] < 0.2 * errors[0]
    clean = helmbench.validate(base, record).score("yaw_rate_rad_s").rmse
    assert errors[1] == pytest.approx(clean, rel=1e-6)


def test_a_doubtful_rudder_sign_warns(record):
    other = {"starboard": "port", "port": "starboard"}[record.meta.positive_rudder]
    wrong = helmbench.Record(
        record.time_s, dict(record.channels), record.name, helmbench.RecordMeta(positive_rudder=other)
    )
    with pytest.warns(helmbench.RudderSignWarning):
        helmbench.validate("response-1", wrong)


def test_files_are_written_both_or_none(found, tmp_path, monkeypatch):
    paths = found.write(tmp_path / "out")
    assert [path.name for path in paths] == list(found.files)
    document = json.loads(paths[0].read_text(encoding="utf-8"))
    assert document["schema"] == 1 and document["scores"][0]["rmse"] == found.scores[0].rmse
    assert paths[1].read_text(encoding="utf-8") == found.to_html()
    (tmp_path / "taken" / "validation.html").mkdir(parents=True)
    with pytest.raises(helmbench.BadInput, match="cannot be written"):
        found.write(tmp_path / "taken")
    assert [path.name for path in (tmp_path / "taken").iterdir()] == ["validation.html"]
