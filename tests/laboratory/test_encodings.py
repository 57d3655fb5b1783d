"""The encoding of a text: by its bytes, by the known words it makes of the header, or as it is said."""

from pathlib import Path

import pytest

from graincal.data import InputError
from graincal.laboratory import vocabulary
from graincal.laboratory.table import read_table

FIELD = Path(__file__).parent.parent / "data" / "field"
# Names of columns and the encodings that such files come in.
WORDS = {
    "cp1252": "Déformation axiale;Déviateur",
    "cp1251": "Осевая деформация;Девиатор напряжений",
    "koi8_r": "Осевая деформация;Девиатор напряжений",
    "cp866": "Осевая деформация;Девиатор напряжений",
    "gb18030": "轴向应变;偏应力",
    "big5": "軸向應變;偏應力",
    "shift_jis": "軸ひずみ;主応力差",
    "euc_kr": "축변형률;축차응력",
    "cp1250": "Odkształcenie osiowe;Napięcie dewiatorowe",
    "cp1254": "Eksenel şekil değiştirme;Deviatör gerilme",
    "iso8859_7": "Αξονική παραμόρφωση;Τάση",
    "utf-8": "轴向应变;偏应力",
    "utf-16": "Осевая деформация;Девиатор напряжений",
    "utf-16-le": "axial strain;q",
    "utf-16-be": "axial strain;q",
}
UNKNOWN = {
    "cp1251": "Ящик яблок;Ёжик",
    "gb18030": "苹果箱子;刺猬",
    "shift_jis": "りんごばこ;はりねずみ",
    "euc_kr": "사과상자;고슴도치",
    "cp1250": "Źdźbło trawy;Jeż",
}
ROWS = "\n0,5;1,5\n1,5;2,5\n"


def written(text: str, encoding: str, folder: Path) -> Path:
    path = folder / "lab.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("encoding", WORDS)
def test_the_encoding_is_the_one_under_which_names_are_known(encoding: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    header = WORDS[encoding]
    monkeypatch.setitem(vocabulary._QUANTITY, vocabulary._plain(header.split(";")[0]), "axial_strain")
    table = read_table(written(header + ROWS, encoding, tmp_path))
    assert (table.encoding, table.header) == (encoding, tuple(header.split(";")))
    assert [decision.what for decision in table.decided] == ([] if encoding in ("utf-8", "utf-16") else ["encoding"])
    assert table.questions == ()
    assert [row.cells for row in table.rows] == [("0,5", "1,5"), ("1,5", "2,5")]


@pytest.mark.parametrize("encoding", UNKNOWN)
def test_where_no_name_is_known_the_encoding_is_asked_for_and_numbers_are_right(encoding: str, tmp_path: Path) -> None:
    header = UNKNOWN[encoding]
    path = written(header + ROWS, encoding, tmp_path)
    table = read_table(path)
    (question,) = table.questions
    assert (question.key, question.option) == ("encoding", "--encoding") and question.proposed == table.encoding and encoding in question.answers
    assert [row.cells for row in table.rows] == [("0,5", "1,5"), ("1,5", "2,5")]
    said = read_table(path, encoding=encoding)
    assert (said.header, said.encoding, said.questions) == (tuple(header.split(";")), encoding, ())


def test_an_encoding_that_is_said_is_used_or_refused(tmp_path: Path) -> None:
    path = written("Déviateur;q" + ROWS, "cp1252", tmp_path)
    assert read_table(path, encoding="cp1252").header[0] == "Déviateur"
    with pytest.raises(InputError, match=r"line 1 is not in the encoding 'utf-8' \(byte 0xe9\)"):
        read_table(path, encoding="utf-8")
    for encoding in ("nonsense", "base64"):
        with pytest.raises(InputError, match=f"there is no encoding '{encoding}'"):
            read_table(path, encoding=encoding)
    assert read_table(written("\ufeffeps;q" + ROWS, "utf-8", tmp_path), encoding="utf-8").header == ("eps", "q")


def test_names_of_the_fields_files_are_shown_readably() -> None:
    assert read_table(FIELD / "russian_cp1251.csv").header == ("Осевая деформация, %", "Девиатор напряжений, кПа", "Объемная деформация, %")
    assert read_table(FIELD / "chinese_gbk.csv").header == ("轴向应变(%)", "偏应力(kPa)", "体积应变(%)")
    assert read_table(FIELD / "portuguese.csv").byte_order_mark
