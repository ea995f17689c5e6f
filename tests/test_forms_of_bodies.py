"""Code outside the methods asks a body, not for its form: members of `BodyForm` instead of `isinstance`."""

import ast
from pathlib import Path

import supple
from supple.body.form_defaults import FormDefaults
from supple.methods import explicit, intrinsic
from supple.reduction import ReducedBody

SOURCES = Path(supple.__file__).parent
MAY_ASK = ("machine", "methods")


def names_of_forms(kind=FormDefaults):
    """Class names of all forms of bodies."""
    own = {each.__name__ for each in kind.__subclasses__()}
    return own.union(*(names_of_forms(each) for each in kind.__subclasses__()))


def asked_for(path, forms):
    """Lines of a file with `isinstance(.., FORM)`."""
    text = path.read_text(encoding="utf-8")
    if not any(form in text for form in forms):
        return
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "isinstance":
            named = {name.id for name in ast.walk(node.args[1]) if isinstance(name, ast.Name)}
            if named & forms:
                yield f"{path.relative_to(SOURCES)}:{node.lineno}"


def test_no_code_outside_machine_and_methods_asks_for_the_form_of_a_body():
    forms = names_of_forms()
    known = {ReducedBody, intrinsic.IntrinsicBody, explicit.ModalSubdomain, explicit.ExplicitShell}
    assert {each.__name__ for each in known} | {"RigidBody", "FullBody", "ExplicitSubdomain"} <= forms
    paths = [path for path in SOURCES.rglob("*.py") if path.relative_to(SOURCES).parts[0] not in MAY_ASK]
    assert not [line for path in paths for line in asked_for(path, forms)]
