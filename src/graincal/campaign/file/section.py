"""Tables of a configuration file, whose mistakes are said in sentences with the key and what was expected."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, get_args, get_origin

from pydantic import BaseModel, ConfigDict, ValidationError, ValidationInfo, ValidatorFunctionWrapHandler, field_validator, model_validator
from pydantic_core import PydanticCustomError

from graincal.data import LONGEST_NAME
from graincal.notation.printable import printable, printable_json
from graincal.suggestion import did_you_mean


class Section(BaseModel):
    """A table of the file. Each field's description says what is expected, as the end of a sentence."""

    called: ClassVar[str] = ""
    """The table's name in the file, where it has one of its own: keys that stand in another table are pointed to it."""

    INSTEAD: ClassVar[dict[str, str]] = {}
    """Of keys that people look for here, what is written instead."""

    MOST: ClassVar[dict[str, float]] = {}
    """Of some keys the largest number, or the most elements of a list, that anybody can mean."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

    def given(self, *left_out: str) -> dict[str, Any]:
        """The keys that the file has, with their values; the others keep the defaults of whoever is handed them."""
        return self.model_dump(exclude_unset=True, exclude=set(left_out))

    @model_validator(mode="before")
    @classmethod
    def _check_keys(cls, table: Any) -> Any:
        if not isinstance(table, dict):
            raise mistake(f" must be a table with {', '.join(cls.model_fields)}, not {show(table)}")
        for key in table:
            if key not in cls.model_fields:
                if key in cls.INSTEAD:
                    raise mistake(f".{key} is not a key that is known here: {cls.INSTEAD[key]}")
                if elsewhere := [table.called for table in Section.__subclasses__() if table.called and key in table.model_fields]:
                    raise mistake(f".{printable(key, LONGEST_NAME)} is not a key that is known here, it belongs under {' or '.join(elsewhere)}")
                raise mistake(
                    f".{printable(key, LONGEST_NAME)} is not a key that is known here{did_you_mean(key, cls.model_fields)}, and one of {', '.join(cls.model_fields)} was expected"
                )
        for key, field in cls.model_fields.items():
            if field.is_required() and key not in table:
                raise mistake(f".{key} is missing, and {field.description} was expected")
        return table

    @field_validator("*", mode="wrap")
    @classmethod
    def _check_value(cls, value: Any, validate: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Any:
        assert info.field_name is not None, "it is asked of each field"
        field = cls.model_fields[info.field_name]
        try:
            found = validate(value)
        except ValidationError as error:
            if said := next((line["msg"] for line in error.errors() if line["type"] == "refused"), None):
                raise mistake(said) from None
            if _holds_sections(field.annotation) and any(line["loc"] or line["type"] == "mistake" for line in error.errors()):
                raise
            raise cls.unexpected(info.field_name, value) from None
        cls._check_size(info.field_name, found)
        return found

    @classmethod
    def _check_size(cls, key: str, value: Any) -> None:
        """Raise the mistake of a size that would fill the memory, or never come to an end."""
        most = cls.MOST.get(key)
        if most is None:
            return
        if isinstance(value, (list, dict)) and len(value) > most:
            raise mistake(f" has {len(value)} elements, and at most {most:,} were expected")
        if isinstance(value, (int, float)) and value > most:
            raise mistake(f" is {show(value)}, and at most {f'{most:,}' if isinstance(most, int) else f'{most:g}'} was expected")

    @classmethod
    def unexpected(cls, key: str, value: Any) -> PydanticCustomError:
        """The mistake of a value that is not what its key expects."""
        field = cls.model_fields[key]
        return mistake(f" must be {field.description}, not {show(value)}{did_you_mean(value, _words(field.annotation))}")


def mistake(words: str) -> PydanticCustomError:
    """What is wrong with a table or a value: the sentence that begins with its key."""
    return PydanticCustomError("mistake", "{words}", {"words": words})


def refused(words: str) -> PydanticCustomError:
    """As `mistake`, of a value that is of the kind that its key expects: said in these words instead of what is expected."""
    return PydanticCustomError("refused", "{words}", {"words": words})


def sentences(error: ValidationError, content: Mapping[str, Any]) -> list[str]:
    """A sentence for each mistake in the content of a file."""
    return [_without_first_marks(f"{_name(line['loc'], content)}{line['msg']}.") for line in error.errors()]


def place(location: tuple[int | str, ...], content: Any) -> str:
    """A value's place by the keys on the way to it: `experiment "drained": reference.strain`. Without the content, elements of lists go by their number."""
    return _without_first_marks(_name(location, content)).rstrip(": ")


def _without_first_marks(text: str) -> str:
    return re.sub(r"(^|: )[. ]", r"\1", text)


def _name(location: tuple[int | str, ...], content: Any) -> str:
    """The keys on the way to a value, each with what parts it from the one before; an element of a list goes by its name, if it has one."""
    name = ""
    for part in location:
        if isinstance(content, dict):
            content = content[part]
        else:
            content = content[part] if isinstance(content, list) and isinstance(part, int) else None
        called = content.get("name") if isinstance(content, dict) else None
        if isinstance(part, str):
            name += f".{printable(part, LONGEST_NAME)}"
        else:
            name += f' "{printable(called, LONGEST_NAME)}": ' if isinstance(called, str) else f" {part + 1}: "
    return name


def _holds_sections(annotation: Any) -> bool:
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return True
    return any(map(_holds_sections, get_args(annotation)))


def _words(annotation: Any) -> list[str]:
    """The words that a value may be one of."""
    if get_origin(annotation) is Literal:
        return [word for word in get_args(annotation) if isinstance(word, str)]
    return [word for argument in get_args(annotation) for word in _words(argument)]


def show(value: Any) -> str:
    """A value as TOML writes it, shortened."""
    try:
        text = printable_json(value)
    except TypeError:
        text = str(value)
    text = printable(text, None)
    return text if len(text) <= 60 else f"{text[:57]}..."
