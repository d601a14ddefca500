"""The log: opened by an outside reader, readable up to any byte it was cut at, and a kill loses less than a second."""

from __future__ import annotations

import io
import json
import os
import signal
import struct
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
import pytest
from log_samples import PERIOD, sample
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader

from steeplejack.planning import Mission, check
from steeplejack.robots.squad import Bay, Squad
from steeplejack.runtime import Recorder, recorder
from steeplejack.runtime.recorder import Event, Picture, Seed, Site, State, StayRecord, VerdictRecord
from steeplejack.worksite import Bridge, Interval, Stay

COUNT = 150  # samples in the log of these tests
CHUNK_RECORD = 0x06
ONCE = {"/worksite": Site, "/robot": Squad, "/mission": Mission, "/seed": Seed}
KINDS = ONCE | {"/state": State, "/event": Event, "/camera": Picture}


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory, mission: Mission, bridge: Bridge, bay: Bay, squad: Squad) -> Path:
    """A log with every topic, as a run writes it."""
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    writer, rng = Recorder(path), np.random.default_rng(5)
    found = [check(stay, squad, bridge.gravity) for stay in bay.stays]
    records = tuple(VerdictRecord(v.stay, v.fits, v.reasons, v.unknown) for v in found)
    stays = tuple(StayRecord.of(stay) for stay in bay.stays)
    writer.write("/worksite", Site(bridge.name, bridge.source, bridge.gravity, stays, records), 0.0)
    writer.write("/robot", squad, 0.0)
    writer.write("/mission", mission, 0.0)
    writer.write("/seed", Seed(4, "0.1"), 0.0)
    for k in range(COUNT):
        writer.write("/state", sample(k * PERIOD, rng), k * PERIOD)
        if k % 40 == 0:
            writer.note(k * PERIOD, f"note {k}")
    picture = Picture({"sec": 1, "nsec": 5}, "overview", bytes(range(256)), "jpeg")
    writer.write("/camera", picture, COUNT * PERIOD)
    writer.note(COUNT * PERIOD, "mission complete")
    writer.close()
    return path


def readable(content: bytes) -> list[tuple[str, int, bytes]]:
    """Topic, time and data of every message an outside reader gets out of a file that may end anywhere."""
    topics: dict[int, str] = {}
    found: list[tuple[str, int, bytes]] = []
    try:
        for item in StreamReader(io.BytesIO(content)).records:
            if isinstance(item, Channel):
                topics[item.id] = item.topic
            elif isinstance(item, Message):
                found.append((topics[item.channel_id], item.log_time, item.data))
    except (McapError, struct.error, ValueError):
        pass
    return found


class Chunk(NamedTuple):
    """A chunk of the file."""

    end: int  # offset of the first byte after it
    times: tuple[int, ...]  # of the messages in it [ns]


def chunks(content: bytes) -> list[Chunk]:
    """Chunks by walking over the records: an opcode, a length of eight bytes and that many bytes each."""
    found: list[Chunk] = []
    offset = 8
    while offset + 9 <= len(content) - 8:
        opcode, length = struct.unpack_from("<BQ", content, offset)
        offset += 9 + length
        if opcode == CHUNK_RECORD:
            found.append(Chunk(offset, tuple(at for _topic, at, _data in readable(content[:offset]))))
    return found


def conforms(value: Any, schema: dict[str, Any], definitions: dict[str, Any]) -> bool:
    """The part of JSON Schema these logs use."""
    if "$ref" in schema:
        return conforms(value, definitions[schema["$ref"].removeprefix("#/$defs/")], definitions)
    if "anyOf" in schema:
        return any(conforms(value, option, definitions) for option in schema["anyOf"])
    if "enum" in schema:
        return value in schema["enum"]
    kinds = {
        "object": dict, "array": list, "string": str, "number": (int, float), "integer": int, "boolean": bool,
        "null": type(None),
    }  # fmt: skip
    if "type" in schema and not isinstance(value, kinds[schema["type"]]):
        return False
    if isinstance(value, dict):
        fields = schema.get("properties", {})
        rest = schema.get("additionalProperties", True)
        inside = all(conforms(item, fields[key], definitions) for key, item in value.items() if key in fields)
        others = [item for key, item in value.items() if key not in fields]
        extra = all(rest is True or (rest is not False and conforms(item, rest, definitions)) for item in others)
        return inside and extra and set(schema.get("required", ())) <= set(value)
    if isinstance(value, list):
        ahead = schema.get("prefixItems", [])
        rest = schema.get("items", {}) or {}
        return all(conforms(v, ahead[k] if k < len(ahead) else rest, definitions) for k, v in enumerate(value))
    return True


def test_an_outside_reader_opens_it(log: Path) -> None:
    with log.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        assert {channel.topic for channel in summary.channels.values()} == set(KINDS)
        messages = list(reader.iter_messages())
    assert len(messages) == summary.statistics.message_count == len(ONCE) + COUNT + 4 + 2
    times = [message.log_time for _schema, _channel, message in messages]
    assert times == sorted(times)


def test_every_topic_carries_a_schema_its_messages_obey(log: Path) -> None:
    seen = set()
    with log.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            shape = json.loads(schema.data)
            assert shape["type"] == "object"
            value = json.loads(message.data)
            definitions = shape.get("$defs", {})
            assert conforms(value, shape, definitions)
            broken = dict(list(value.items())[1:])
            if channel.topic == "/state":
                assert not conforms(broken, shape, definitions)
            seen.add((channel.topic, schema.name))
    named = {topic: f"steeplejack.{kind.__name__}" for topic, kind in KINDS.items()}
    assert seen == set((named | {"/camera": "foxglove.CompressedImage"}).items())


def test_messages_come_back_as_they_were(log: Path, mission: Mission, squad: Squad) -> None:
    found = {topic: data for topic, _at, data in readable(log.read_bytes())}
    assert msgspec.json.decode(found["/mission"], type=Mission) == mission
    assert msgspec.json.decode(found["/robot"], type=Squad) == squad
    assert msgspec.json.decode(found["/event"], type=Event).text == "mission complete"
    assert msgspec.json.decode(found["/camera"], type=Picture).data == bytes(range(256))
    last = sample(0.0, np.random.default_rng(5))
    first = next(data for topic, _at, data in readable(log.read_bytes()) if topic == "/state")
    assert msgspec.json.decode(first, type=State) == last


def test_cut_anywhere_it_gives_every_whole_chunk(log: Path) -> None:
    content = log.read_bytes()
    whole, blocks = readable(content), chunks(content)
    assert len(blocks) > 5
    cuts = set(np.random.default_rng(9).integers(0, len(content), 150).tolist())
    cuts |= {block.end + shift for block in blocks for shift in (-1, 0, 1, 8, 9)}
    for cut in sorted(cuts):
        kept = [len(block.times) for block in blocks if block.end <= cut]
        found = readable(content[:cut])
        assert len(found) >= (kept[-1] if kept else 0)
        assert found == whole[: len(found)]


@pytest.mark.parametrize("short", [True, False])
def test_no_chunk_spans_a_second(tmp_path: Path, short: bool) -> None:
    """Also where every number is a bare zero and a sample takes the least space."""
    path = tmp_path / "run.mcap"
    writer = Recorder(path)
    for k in range(100):
        writer.write("/state", sample(k * PERIOD, None if short else np.random.default_rng(k)), k * PERIOD)
    writer.close()
    counts = [0, *(len(block.times) for block in chunks(path.read_bytes()))]
    assert max(after - before for before, after in pairwise(counts)) * PERIOD < 1.0


@pytest.mark.parametrize("samples", [23, 47])
def test_a_kill_loses_less_than_a_second(tmp_path: Path, samples: int) -> None:
    path = tmp_path / "run.mcap"
    program = Path(__file__).with_name("log_samples.py")
    with subprocess.Popen([sys.executable, str(program), str(path)], stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None
        for _ in range(samples):
            written = float(run.stdout.readline())
        os.kill(run.pid, signal.SIGKILL)
        run.wait(10.0)
    assert run.returncode == -signal.SIGKILL
    times = [at for _topic, at, _data in readable(path.read_bytes())]
    assert written == pytest.approx((samples - 1) * PERIOD)
    assert written - (times[-1] * 1e-9 if times else 0.0) < 1.0
    np.testing.assert_allclose(np.diff(times), PERIOD * 1e9, atol=1.0)


@pytest.mark.parametrize("tension", [None, 3.5e6])
def test_a_stay_comes_back_from_its_record(tension: float | None) -> None:
    zones = (Interval(0.0, 2.5, "end zone", None, "estimate"), Interval(20.0, 20.6, "obstacle", 0.02, "collar"))
    ends = ((40.0, 14.0, 50.0), (0.0, 12.0, 110.0))
    stay = Stay("T1L-M05", "1", "L", "main", 5, *ends, 0.12, 588.6, tension, 1.4e9 if tension else None, zones)
    record = StayRecord.of(stay)
    again = msgspec.json.decode(msgspec.json.encode(record), type=StayRecord).stay()
    assert again == stay
    np.testing.assert_array_equal(again.position(np.linspace(0.0, 70.0, 9)), stay.position(np.linspace(0.0, 70.0, 9)))


def test_time_stamps_are_those_of_the_run(tmp_path: Path) -> None:
    writer = Recorder(tmp_path / "run.mcap")
    writer.note(1.25, "here", "phase")
    writer.close()
    ((topic, at, data),) = readable((tmp_path / "run.mcap").read_bytes())
    assert (topic, at) == ("/event", 1_250_000_000)
    assert msgspec.json.decode(data, type=recorder.Event) == Event(1.25, "phase", "here")
