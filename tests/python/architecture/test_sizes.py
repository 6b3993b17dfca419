"""scripts/sizes.py counts lines, nesting and parameters of functions correctly."""

import runpy
from pathlib import Path

import pytest

pytest.importorskip("lizard")
SIZES = runpy.run_path(str(Path(__file__).parents[3] / "scripts" / "sizes.py"))

CPP = """
void chain(int a, std::map<int, double> b) {
  for (int i = 0; i < a; ++i)
    if (i == 1) {
      a = i ? 2 : 3;
    } else if (i == 2) {
      while (a) --a;
    } else {
      parallel_for(a, [&](int k) {
        if (k) a = "}{"[k];  // }}
      });
    }
}
"""
PYTHON = """
def chain(self, a, b, *, c=1, **rest):
    for i in a:
        if i:
            pass
        elif b:
            with c:
                pass
        else:
            try:
                pass
            finally:
                while c:
                    pass
"""


def measured(functions, name, text, tmp_path):
    (tmp_path / name).write_text(text)
    (found,) = SIZES[functions](str(tmp_path / name))
    return found.lines, found.nesting, found.parameters


def test_a_chain_of_else_if_and_a_lambda_add_no_depth_in_cpp(tmp_path):
    assert measured("cpp_functions", "a.cpp", CPP, tmp_path) == (12, 3, 2)


def test_keyword_only_parameters_and_self_are_not_counted_in_python(tmp_path):
    assert measured("python_functions", "a.py", PYTHON, tmp_path) == (13, 4, 2)


def test_broken_rules_are_reported_in_words():
    function = SIZES["Function"]("a.py", "f", line=1, lines=61, nesting=5, parameters=6)
    assert function.excesses() == [
        "61 lines (at most 60)",
        "5 nested control structures (at most 4)",
    ]
