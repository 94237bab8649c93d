"""Files within compressed ones: of gzip, and of zip archives."""

from __future__ import annotations

import io
import zipfile
import zlib
from pathlib import Path, PurePosixPath

from ...models.errors import BadInput
from ...models.files import MOST_BYTES

GZIP, ZIP = b"\x1f\x8b", b"PK\x03\x04"
OFFICE = ("[Content_Types].xml", "mimetype", "content.xml")
"""Members by which a zip archive is a document of an office program: a workbook is read as one."""
MOST_MEMBERS = 200
"""Files of an archive that are read."""
HIDDEN = ("__MACOSX/", ".")
"""How names of files begin that systems add to an archive."""


def is_compressed(data: bytes) -> bool:
    """Whether the content of a file is compressed, and not the document of an office program."""
    return data.startswith(GZIP) or (data.startswith(ZIP) and not _is_document(data))


def contents_of(data: bytes, path: Path) -> list[tuple[Path, bytes]]:
    """(name, bytes) of the files within a compressed file; the file itself where it is none.

    A file of gzip is called as without `.gz`, one of an archive by its name in that.  Of a file of gzip that was cut
    the beginning is read.

    Raises
    ------
    BadInput : the file is damaged, encrypted, too large when unpacked, or holds no or too many files.
    """
    if data.startswith(GZIP):
        found = _unzipped(data, path)
        if found[257:262] == b"ustar":
            raise BadInput("a compressed tar archive", file=path, hint="unpack it first")
        return [(path.with_suffix("") if path.suffix.lower() == ".gz" else path, found)]
    if is_compressed(data):
        return _members(data, path)
    return [(path, data)]


def _unzipped(data: bytes, path: Path) -> bytes:
    """The content of a file of gzip, of all its parts."""
    out, size, rest = [], 0, data
    while rest.startswith(GZIP):
        part = zlib.decompressobj(wbits=31)
        try:
            out.append(part.decompress(rest, MOST_BYTES - size + 1))
        except zlib.error:
            if not out or not any(out):
                raise BadInput("a damaged file of gzip", file=path, hint="is it whole?") from None
            break
        size += len(out[-1])
        if size > MOST_BYTES:
            raise _too_large(path)
        rest = part.unused_data
    return b"".join(out)


def _is_document(data: bytes) -> bool:
    """Whether an archive is a document of an office program."""
    return any(name.encode() in data[:2000] or name.encode() in data[-20000:] for name in OFFICE)


def _members(data: bytes, path: Path) -> list[tuple[Path, bytes]]:
    out, size = [], 0
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = [i.filename for i in archive.infolist() if not i.is_dir() and not i.filename.startswith(HIDDEN)]
            if len(names) > MOST_MEMBERS:
                raise BadInput(f"an archive of {len(names)} files", file=path, hint=f"at most {MOST_MEMBERS} are read")
            for name in names:
                with archive.open(name) as member:
                    own = member.read(MOST_BYTES - size + 1)
                size += len(own)
                if size > MOST_BYTES:
                    raise _too_large(path)
                out.append((path.joinpath(*_inside(name)), own))
    except BadInput:
        raise
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, ValueError, OSError) as error:
        said = (
            "an encrypted archive" if "encrypted" in str(error) else "a damaged archive, or of a kind that is not read"
        )
        raise BadInput(said, file=path, hint="unpack it first") from None
    if not out:
        raise BadInput("an archive without files", file=path)
    return out


def _inside(name: str) -> list[str]:
    """The parts of a member's name, which never lead out of the archive."""
    return [part for part in PurePosixPath(name.replace("\\", "/")).parts if part not in ("/", "..")]


def _too_large(path: Path) -> BadInput:
    return BadInput(f"a compressed file of more than {MOST_BYTES / 2**30:.2g} GiB", file=path, hint="unpack it first")
