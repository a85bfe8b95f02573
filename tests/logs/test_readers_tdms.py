"""TDMS: groups, properties, clocks, and files that were not written to their end."""

import struct

import numpy as np
import pytest
from nptdms import ChannelObject, GroupObject, RootObject

import formats


def without_time(rows: int, properties: list[dict[str, float]]) -> bytes:
    values = {name: column for name, column in formats.columns(rows).items() if name != "time"}
    channels = [
        ChannelObject("run", name, column, {"unit_string": formats.UNITS[name], **clock})
        for (name, column), clock in zip(values.items(), properties, strict=True)
    ]
    return formats.tdms_file([RootObject(formats.KEYS), *channels])


def test_groups_are_runs_with_their_own_set_points_and_rows_counted_through(read) -> None:
    first, second = formats.columns(30), formats.columns(20)
    content = formats.tdms_file(
        [
            RootObject({"oil": "4102"}),
            GroupObject("a\x1b", {"inlet_temperature_c": 25.0}),
            *formats.tdms_channels("a\x1b", first),
            GroupObject("notes"),
            ChannelObject("notes", "humidity", np.arange(4.0)),
            GroupObject("a\x07", {"inlet_temperature_c": 70}),
            *formats.tdms_channels("a\x07", second),
        ]
    )
    reading = read(content)
    # names are made printable and stay apart
    assert [run.run_id for run in reading.runs] == ["log:a?", "log:a?-2"]
    assert [run.set_points["inlet_temperature_c"] for run in reading.runs] == [25, 70]
    assert reading.runs[1].samples["row"].tolist() == list(range(35, 55))
    # a group that is no run is listed
    (refusal,) = reading.refusals
    assert (refusal.rule, refusal.run_id, refusal.refused_rows) == ("columns", "log:notes", 4)
    assert (refusal.first_row, refusal.last_row, reading.row_count) == (31, 34, 54)


def test_time_follows_from_the_sampling_interval_where_no_channel_has_it(read) -> None:
    clock = {"wf_increment": 0.02, "wf_start_offset": 1.5}
    (run,) = read(without_time(40, 5 * [clock])).runs
    np.testing.assert_allclose(run.samples["time_s"], 1.5 + 0.02 * np.arange(40), rtol=1e-12)
    # a channel without a clock has no time
    (refusal,) = read(without_time(40, [clock, *3 * [{"wf_increment": 0.04}], {}])).refusals
    assert "columns time" in refusal.reason


def test_instants_become_seconds_since_the_first(read) -> None:
    values = formats.columns(10)
    instants = np.datetime64("2026-01-10T08:00:00", "us") + np.arange(10) * np.timedelta64(20, "ms")
    (run,) = read(formats.tdms({**values, "time": instants})).runs
    np.testing.assert_allclose(run.samples["time_s"], 0.02 * np.arange(10), atol=1e-12)


def test_rows_that_only_some_channels_have_are_refused_by_range(read) -> None:
    # channels that mean nothing may be of any length and type
    others = {"vibration": np.arange(999.0), "who": np.array(["a", "b"])}
    values = {**formats.columns(50), **others}
    values["load"] = values["load"][:44]
    reading = read(formats.tdms(values))
    (refusal,) = reading.refusals
    assert (refusal.rule, refusal.first_row, refusal.last_row) == ("unreadable_row", 45, 50)
    assert (reading.row_count, len(reading.runs[0])) == (50, 44)


@pytest.mark.parametrize("share", [0.35, 0.5, 0.65, 0.8, 0.95, 0.999])
def test_incomplete_final_segment_is_reported_and_rows_before_it_kept(read, share: float) -> None:
    values = formats.columns(600)
    content = formats.tdms(values, segments=10)
    reading = read(content[: int(share * len(content))])
    (run,) = reading.runs
    assert "within segment" in run.refusal.reason
    kept = len(run)
    # complete segments of 60 rows, and of the last one what its last channel still got
    complete = (int(run.refusal.reason.split("segment ")[1].split(",")[0]) - 2) * 60
    assert 0 < complete <= kept < complete + 60
    assert run.samples["time_s"].tolist() == values["time"][:kept].tolist()
    np.testing.assert_allclose(run.samples["load_n"] / 9.80665, values["load"][:kept], rtol=1e-12)
    assert kept + sum(refusal.refused_rows for refusal in reading.refusals) == reading.row_count


def test_cut_within_a_lead_in_is_noticed_although_no_row_is_lost(read) -> None:
    content = formats.tdms(formats.columns(600), segments=2)
    length = content.rindex(b"TDSm") + 12
    # the last is what LabVIEW leaves behind when it is killed: a segment of unknown length
    killed = content[:length] + b"\xff" * 8 + content[length + 8 :]
    for cut in (content + b"TDSm", content + b"TD", content + b"TDSm" + bytes(20), killed):
        (run,) = read(cut).runs
        assert run.refusal.rule == "truncated"
        assert len(run) == 600


@pytest.mark.parametrize("bit", range(3, 16))
def test_changed_bit_in_the_length_of_the_names_loses_no_row(read, bit: int) -> None:
    """The values of all channels would begin later, and the last rows of the file be cut off."""
    content = bytearray(formats.tdms(formats.columns(1000)))
    content[content.rindex(b"TDSm") + 20 + bit // 8] ^= 1 << bit % 8
    reading = read(bytes(content))
    assert not reading.runs
    assert [refusal.rule for refusal in reading.refusals] == ["damaged_file"]


def test_absurd_count_of_values_neither_fills_the_memory_nor_invents_rows(read) -> None:
    content = formats.tdms(formats.columns(60))
    reading = read(content.replace(struct.pack("<Q", 60), struct.pack("<Q", 1 << 40)))
    assert reading.row_count <= 60


@pytest.mark.parametrize("name", ["NI_Number_Of_Scales", "NI_Scale[0]_Table_Scaled_Values_Size"])
def test_scalings_without_end_are_refused(read, name: str) -> None:
    channels = formats.tdms_channels("run", formats.columns(9))
    channels[0].properties[name] = 1 << 60
    (refusal,) = read(formats.tdms_file([RootObject(formats.KEYS), *channels])).refusals
    assert refusal.rule == "damaged_file"
    assert name in refusal.reason
