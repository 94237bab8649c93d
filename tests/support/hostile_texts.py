"""Texts that try to become code, markup, a path or another line where a program writes them into a source."""

HOSTILE = {
    "ends of comments": [
        *("*/", "*\\", "*\\ int x; /*", "*/ int x; /*", "*\\/ int x;", "/*", "//", "*??/", "?" + "?/", "%}", "%{"),
        *("...", "-->", "--->", "--", "-", "a--", "--!>", "<!--", "]]>", "?>", "<![CDATA[", "#", "%", "{#", "#}"),
    ],
    "quotes": [
        *('"', '""', '"""', "'", "''", "'''", "`", "``", 'ends in "', "ends in '", '"""\nimport os\n"""'),
        *('"); abort();', "'; system('id'); '", "'+__import__('os').system('id')+'", '" onload="alert(1)', "a'b''c"),
    ],
    "backslashes": [
        *("\\", "\\\\", "ends in \\", '\\"', "\\'", "\\n", "\\x22", "\\u0022", "\\N{QUOTATION MARK}", "*\\\\/"),
    ],
    "line breaks": [
        *(f"one{end}import os" for end in ("\n", "\r", "\r\n", "\x0b", "\x0c", "\x1c", "\x85", "\u2028", "\u2029")),
        *("\n#include </etc/passwd>", "\n#error no", "\n%}\nsystem('id')", "\n</inertial>", "\n", "\\\nint x;"),
    ],
    "directions and what is not seen": [
        *("\u202e*/", "\u2066/*\u2069", "\u200b", "a\u200d", "\ufeff", "\u00ad", "\u2060", "\u180e", "\U000e0041"),
        *("\u115f", "\u3164", "\uffa0", "\u05d0\u05d1 = 1", "\u0627\u0644", "\u0661\u0662", "e\u0301\u0301\u0301"),
    ],
    "controls": ["\0", "\x1b[2J", "\x07", "\x7f", "\x9b", "\ud800", "\ufffe", "\uffff", "\ue000", "\U0010ffff"],
    "templates": [
        *("@EQUATIONS@ @COUNT@", "@GUID@", "{heading}", "{0}", "{{", "}}", "{numbers!r}", "%s", "%(name)s"),
        *("$HOME", "$(id)", "{{ 7*7 }}", "{% raw %}", "${x}", "#{x}", "!r", "__import__", "_Pragma("),
    ],
    "markup": [
        *("<script>alert(1)</script>", "</inertial><plugin/>", "&lt;", "&#x3c;", "&x;"),
        *("<!DOCTYPE a [<!ENTITY b 'c'>]>"),
    ],
    "full width": [
        *("\uff0a\uff0f", "\uff07", "\uff02", "\uff3c", "\uff1c\uff1e", "\u2039\u203a", "\u037e", "\u1fef", "\u212a"),
    ],
    "names": [
        *("con", "NUL", "aux", "class", "math", "Math", "np", "numpy", "os", "int", "double", "end", "function"),
        *("sin", "abs", "derivative", "NUMBERS", "RUDDER", "float", "None", "p", "1st", "_", " ", ".."),
        *("../../etc/passwd", "/etc/x", "-o", "--force", "C:\\x", "a\0b", "a:b", "~", "*", "$x", "a" * 100_000),
        *("é" * 1000, "日本丸", "x.m", ".hidden", "K", "N_v"),
    ],
}  # fmt: skip
"""Kind -> texts."""
KINDS = list(HOSTILE)
