"""What of an answer counts: numbers, truth values, codes and places; no prose, no key names, no times."""

import hashlib
import json
import re

from signals import wav_chunks

# Times, operations and sizes of the program itself, and what follows from them; how networks are stepped.
VOLATILE = re.compile(r"^ns_|_ns$|^ns_per_frame$|^of_real_time$|^nothing_cheaper|^run_s$|^run_seconds$|"
                      r"^network_solvers$|^multiplications|^error_bound$|real_time_factor|memory_bytes$|^when$|^written$|"
                      r"^root$|^program$")
# Strings that are codes rather than prose.
CODES = {"verdict", "at_0.98", "at_1.02"}
PLACE = re.compile(r"^(?:[^\s:]*/)?([^\s:/]+\.(?:toml|wav|jsonl)):(\d+):(\d+):|^(--[a-z-]+):", re.M)


class Number(str):
    pass


def parse(text):
    return json.loads(text, parse_float=Number, parse_int=Number)


def numbers(value, key="", sort=False):
    """In the order of the document; `sort`: lists of results come in an order that depends on times."""
    if isinstance(value, dict):
        for name, item in value.items():
            if not VOLATILE.search(name):
                yield from numbers(item, name, sort)
    elif isinstance(value, list):
        items = [list(numbers(item, key, sort)) for item in value]
        inside = [word for item in (sorted(items) if sort else items) for word in item]
        yield from ["["] + inside + ["]"] if inside else []
    elif isinstance(value, Number):
        yield repr(float(value))
    elif isinstance(value, bool) or value is None:
        yield str(value)
    elif key in CODES and re.fullmatch(r"[a-z0-9_ -]{1,30}", value):
        yield value


def of_json(text, sort=False):
    return " ".join(numbers(parse(text), sort=sort))


def of_errors(text):
    """file:line:column of each error, or the option."""
    return " ".join(f"{m[1]}:{m[2]}:{m[3]}" if m[1] else m[4] for m in PLACE.finditer(text))


def of_wav(path):
    if not path.exists():
        return "no file"
    chunks = wav_chunks(path)
    digest = hashlib.sha256(chunks.get("fmt ", b"") + chunks.get("data", b"")).hexdigest()
    return f"{digest[:32]} {len(chunks.get('data', b''))} bytes"


def digest(text):
    return hashlib.sha256(text.encode()).hexdigest()[:16]
