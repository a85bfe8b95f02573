"""Logs in the encodings of their countries are read with the names that they have."""

import numpy as np
import pytest

import formats
from bad_logs import CONFIG
from oilfilm.logs.ingest import read_log
from oilfilm.logs.text_rows import encoding_of

VALUES = formats.columns(30)
# language -> encodings, names of the columns in the order of VALUES, header line of the oil
LANGUAGES = {
    "Japanese": (
        ["cp932", "utf-8", "utf-16"],
        "時間 荷重 摩擦力 ボール回転数 ディスク回転数 油温".split(),
        "潤滑油",
    ),
    "Chinese": (["gb18030", "utf-8"], "时间 载荷 摩擦力 球转速 盘转速 入口温度".split(), "润滑油"),
    "Russian": (
        ["cp1251", "koi8_r", "utf-8"],
        ["Время", "Нагрузка", "Сила трения", "Скорость шара", "Скорость диска", "Температура"],
        "Масло",
    ),
    "German": (
        ["cp1252", "utf-8"],
        ["Zeit", "Last", "Reibkraft", "Kugel für Prüfung", "Scheibe", "Öltemperatur"],
        "Öl",
    ),
    "French": (
        ["cp1252"],
        ["Temps", "Charge", "Force", "Vitesse bille", "Vitesse disque", "Température entrée"],
        "Huile utilisée",
    ),
    "Taiwanese": (["big5"], "時間 載荷 摩擦力 球轉速 盤轉速 入口溫度".split(), "潤滑油"),
    "Polish": (
        ["cp1250"],
        [
            "Czas",
            "Obciążenie",
            "Siła tarcia",
            "Prędkość kuli",
            "Prędkość tarczy",
            "Temperatura łożyska",
        ],
        "Olej źródłowy",
    ),
}
CASES = [
    (language, encoding)
    for language, (encodings, _, _) in LANGUAGES.items()
    for encoding in encodings
]


@pytest.mark.parametrize(("language", "encoding"), CASES)
def test_log_of_a_country_is_read(language: str, encoding: str) -> None:
    _, names, oil = LANGUAGES[language]
    columns = {quantity: {"name": name} for quantity, name in zip(VALUES, names, strict=True)}
    config = CONFIG.with_changes({"campaign": {"columns": columns, "header": {"oil": oil}}})
    units = "s N N rpm rpm degC".split()
    lines = [
        f"{oil},4102",
        ",".join(f"{name} ({unit})" for name, unit in zip(names, units, strict=True)),
        *(
            ",".join(f"{cell:.3f}" for cell in row)
            for row in np.column_stack(list(VALUES.values()))
        ),
    ]
    values = "\r\n".join([*lines, ""]).encode(encoding)
    _, reading = read_log(values, "log", config)
    (run,) = reading.runs
    assert (run.oil_name, len(run)) == ("4102", 30)
    np.testing.assert_allclose(run.samples["load_n"], VALUES["load"], atol=5e-4)
    if not encoding.startswith("utf"):
        assert reading.dialect.encoding == encoding


@pytest.mark.parametrize("sign", ["°C", "µm", "m³", "kg/m³ and °C", "10±1 °C", "é"])
def test_one_western_sign_is_western(sign: str) -> None:
    text = f"# note: {sign}\ntime_s,load_n\n0.0,80\n"
    assert encoding_of(text.encode("cp1252")) == "cp1252"


@pytest.mark.parametrize("row_count", [1_000, 9_000, 12_000])
def test_the_length_of_a_log_does_not_change_its_encoding(row_count: int) -> None:
    # one word of the header; each row has a word of one letter and a word of more
    text = "Время;Режим\n" + "1,5;в норме\n" * row_count
    assert encoding_of(text.encode("cp1251")) == "cp1251"


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_a_block_of_zeros_does_not_change_the_order_of_bytes(encoding: str) -> None:
    rows = "time;load\n" + "0.5;80.0\n" * 30
    first, second = rows[:5].encode(encoding), rows[5:].encode(encoding)
    assert encoding_of(first + bytes(512) + second) == encoding
