"""Classes of case-file tables, generated from the classes of the objects that the tables describe."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, reduce
from operator import or_
from types import NoneType, UnionType
from typing import Annotated, Any, ClassVar, Literal, Union, get_args, get_origin, get_type_hints

from pydantic import Field, GetCoreSchemaHandler, create_model
from pydantic_core import CoreSchema

from supple import arguments
from supple.importers.toml import CheckedTable, KeyPath, NonNegative, Positive


@dataclass(frozen=True)
class Key:
    """The key of a parameter; its fields state the differences from the parameter.

    type : type of its values; by default the parameter's type
    description : for messages; by default from the docstring of the class, if the type is the parameter's
    name : by default the parameter's name
    default : by default the parameter's default
    through : function from the value and the context of `build` to the argument; None: the value itself
    """

    type: Any = None
    description: str = ""
    name: str = ""
    default: Any = inspect.Parameter.empty
    through: Callable[..., Any] | None = None


@dataclass(frozen=True)
class Plan:
    """How a table becomes an object: the class, and for each parameter its key.

    A parameter that is an object itself has a plan instead of a key.
    """

    makes: Callable[..., Any]
    parameters: Mapping[str, Key | Plan]

    def made(self, table: CheckedTable, *context: Any) -> Any:
        """The object; None if a required parameter has no value in the table."""
        given = {}
        for parameter, source in self.parameters.items():
            value = source.made(table, *context) if isinstance(source, Plan) else getattr(table, source.name)
            value = value.build(*context) if isinstance(value, Made) else value
            if isinstance(source, Key) and source.through is not None:
                value = source.through(value, *context)
            if value is not None or NoneType in get_args(_hints(self.makes)[parameter]):
                given[parameter] = value
            elif _parameters(self.makes)[parameter].default is inspect.Parameter.empty:
                return None
        return self.makes(**given)


class Made(CheckedTable):
    """A table that describes one object."""

    choice: ClassVar[str] = "kind"
    """The key whose value selects the class of the table."""
    plan: ClassVar[Plan]

    @property
    def chosen(self) -> str:
        """The value of the key `choice`."""
        return getattr(self, self.choice)

    def build(self, *context: Any) -> Any:
        """The object.

        context : further inputs, the same for all tables of one `OneOf`, such as the folder of laws' files
        """
        return type(self).plan.made(self, *context)


def part(makes: Callable[..., Any], **by_hand: Any) -> tuple[Callable[..., Any], dict[str, Any]]:
    """A parameter that is an object: its own parameters are keys of the table. Arguments as in `table_of`."""
    return makes, by_hand


def table_of(
    makes: Callable[..., Any], kind: str | None = None, base: type[Made] = Made, **by_hand: Any
) -> Any:
    """The table of a class: its parameters are the keys, with their types, ranges, defaults and descriptions.

    Descriptions are lines `name : text` of the docstrings of the class and those it inherits from.

    kind : value of the key `base.choice` that selects this table; None: the table has no such key
    base : table with the common keys of a section
    by_hand : by parameter, the differences: a type, a `Key`, a `part`, or None for a parameter without key
    """
    fields: dict[str, Any] = {} if kind is None else {base.choice: (Literal[kind], ...)}  # ty: ignore[invalid-type-form]
    plan = _planned(makes, by_hand, fields, base.model_fields)
    made = create_model(makes.__name__, __base__=base, __doc__=(makes.__doc__ or "").split("\n")[0], **fields)  # ty: ignore[missing-attribute]
    made.plan = plan
    return made


def _planned(
    makes: Callable[..., Any],
    by_hand: Mapping[str, Any],
    fields: dict[str, Any],
    shared: Mapping[str, Any],
) -> Plan:
    """The plan of a class; adds its keys to `fields`."""
    plan: dict[str, Key | Plan] = {}
    hints, descriptions = _hints(makes), _descriptions(makes)
    unknown = [name for name, own in by_hand.items() if own is not None and name not in _parameters(makes)]
    if unknown:
        raise TypeError(f"{makes.__name__} has no parameter {', '.join(unknown)}")  # ty: ignore[missing-attribute]
    for name, parameter in _parameters(makes).items():
        own = by_hand.get(name, Key())
        if own is None:
            continue
        if isinstance(own, tuple):
            inner, its_own = own
            plan[name] = _planned(inner, its_own, fields, shared)
            continue
        own = own if isinstance(own, Key) else Key(own)
        key = own.name or name
        plan[name] = replace(own, name=key)
        if key in fields or (key in shared and name not in by_hand):
            continue
        default = parameter.default if own.default is inspect.Parameter.empty else own.default
        kind = _of_toml(hints[name] if own.type is None else own.type)
        description = own.description or (descriptions.get(name) if own.type is None else None)
        if default is inspect.Parameter.empty:
            default = ...
        elif not (
            default is ...
            or isinstance(default, str | int | tuple | Made)
            or (isinstance(default, float) and math.isfinite(default))
        ):
            # Not possible in a file: the class's own default applies.
            kind, default = kind | None, None
        fields[key] = (kind, Field(default, description=description))
    return Plan(makes, plan)


@cache
def _parameters(makes: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    return inspect.signature(makes).parameters


@cache
def _hints(makes: Callable[..., Any]) -> Mapping[str, Any]:
    return get_type_hints(makes, include_extras=True)


_DESCRIBED = re.compile(
    r"(?:^ {4}| {4,})(\w+(?:, \w+)*) : +((?:(?! {4,}\w+(?:, \w+)* : )(?:.|\n {8,}(?=\S)))+)", re.MULTILINE
)


@cache
def _descriptions(makes: Any) -> Mapping[str, str]:
    """Texts of lines `name, name : text`, continued on lines with more indentation."""
    found: dict[str, str] = {}
    for each in reversed(inspect.getmro(makes)):
        for names, text in _DESCRIBED.findall(each.__doc__ or ""):
            found |= dict.fromkeys(names.split(", "), " ".join(text.split()))
    return found


def _of_toml(hint: Any) -> Any:
    """The type of the key of a parameter: tuples become arrays, and numbers keep their range."""
    ranges = {arguments.Positive: Positive, arguments.NotNegative: NonNegative}
    if hint in ranges:
        return ranges[hint]
    inner = tuple(map(_of_toml, get_args(hint)))
    if get_origin(hint) is tuple:
        return Annotated[tuple[inner], Field(strict=False)]  # ty: ignore[invalid-type-form]
    return reduce(or_, inner) if get_origin(hint) in (Union, UnionType) else hint


def named_in(table: Any, value: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Any, str]]:
    """All values of keys of type `Annotated[str, WORD]`, nested ones too: path, value, WORD.

    table : class of the table, or type of the value, at the path
    """
    while get_origin(table) is Annotated:
        table, *metadata = get_args(table)
        yield from ((path, value, word) for word in metadata if isinstance(word, str))
        table = next((each.chosen(value) for each in metadata if isinstance(each, OneOf)), None) or table
    if get_origin(table) in (Union, UnionType):
        for option in get_args(table):
            yield from named_in(option, value, path)
    elif get_origin(table) is tuple and isinstance(value, list):
        for position, item in enumerate(value):
            yield from named_in(get_args(table)[0], item, (*path, position))
    elif isinstance(table, type) and issubclass(table, CheckedTable) and isinstance(value, Mapping):
        for key, kind in _naming_keys(table):
            if key in value:
                yield from named_in(kind, value[key], (*path, key))


@cache
def _naming_keys(table: type[CheckedTable]) -> tuple[tuple[str, Any], ...]:
    """Keys of a table that `named_in` may find, with their types; most tables have none."""
    kinds: dict[str, Any] = {}
    for key, field in table.model_fields.items():
        kinds[key] = Annotated[field.annotation, *field.metadata, None]  # ty: ignore[invalid-type-form]
    return tuple((key, kind) for key, kind in kinds.items() if _may_name(kind))


def _may_name(kind: Any) -> bool:
    """Whether a type contains an `Annotated[str, WORD]` at any level."""
    if get_origin(kind) is Annotated:
        inner, *metadata = get_args(kind)
        choices = [table for each in metadata if isinstance(each, OneOf) for table in each.tables]
        return any(isinstance(each, str) for each in metadata) or any(map(_may_name, (inner, *choices)))
    if isinstance(kind, type) and get_origin(kind) is None and issubclass(kind, CheckedTable):
        return bool(_naming_keys(kind))
    return any(map(_may_name, get_args(kind)))


class OneOf:
    """The choice among tables by a key, for `Annotated[Made, OneOf(...)]`."""

    def __init__(self, *tables: Any, by: str = "kind") -> None:
        self.tables, self.by = tables, by

    def chosen(self, value: Any) -> Any:
        """The table selected by a value of a file; None if there is none."""
        chosen = value.get(self.by) if isinstance(value, Mapping) else None
        return next(
            (each for each in self.tables if chosen in get_args(each.model_fields[self.by].annotation)), None
        )

    def __get_pydantic_core_schema__(self, _: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Schema of the union of the tables."""
        return handler.generate_schema(Annotated[reduce(or_, self.tables), Field(discriminator=self.by)])  # ty: ignore[invalid-type-form]
