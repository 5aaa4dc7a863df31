"""Keys that reach Blender as from a keyboard, and pictures of the screen, through the X server.

``Window.event_simulate`` puts events behind the place where Blender notices that ESC is pressed while it renders, so a
render cannot be cancelled with it. The events here are sent to all of Blender's windows by libX11, which Blender on X
has loaded anyway. Blender's own screenshots are black where OpenGL draws in software, so they are taken here as well.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import struct
import time
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["press_key", "screen_pixels", "write_png"]

_KEYSYMS = {"ESC": 0xFF1B, "F12": 0xFFC9}
_PRESS, _RELEASE = 2, 3
_MASKS = {_PRESS: 1, _RELEASE: 2}


class _KeyEvent(ctypes.Structure):
    _fields_ = (
        ("type", ctypes.c_int),
        ("serial", ctypes.c_ulong),
        ("send_event", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("window", ctypes.c_ulong),
        ("root", ctypes.c_ulong),
        ("subwindow", ctypes.c_ulong),
        ("time", ctypes.c_ulong),
        ("x", ctypes.c_int),
        ("y", ctypes.c_int),
        ("x_root", ctypes.c_int),
        ("y_root", ctypes.c_int),
        ("state", ctypes.c_uint),
        ("keycode", ctypes.c_uint),
        ("same_screen", ctypes.c_int),
    )


class _Image(ctypes.Structure):
    _fields_ = (
        ("width", ctypes.c_int),
        ("height", ctypes.c_int),
        ("xoffset", ctypes.c_int),
        ("format", ctypes.c_int),
        ("data", ctypes.c_void_p),
        ("byte_order", ctypes.c_int),
        ("bitmap_unit", ctypes.c_int),
        ("bitmap_bit_order", ctypes.c_int),
        ("bitmap_pad", ctypes.c_int),
        ("depth", ctypes.c_int),
        ("bytes_per_line", ctypes.c_int),
        ("bits_per_pixel", ctypes.c_int),
    )


class _Event(ctypes.Union):
    _fields_ = (("key", _KeyEvent), ("padding", ctypes.c_long * 24))


def _library() -> ctypes.CDLL:
    x = ctypes.CDLL(ctypes.util.find_library("X11") or "libX11.so.6")
    x.XOpenDisplay.restype = ctypes.c_void_p
    x.XOpenDisplay.argtypes = [ctypes.c_char_p]
    x.XDefaultRootWindow.restype = ctypes.c_ulong
    x.XDefaultRootWindow.argtypes = [ctypes.c_void_p]
    x.XKeysymToKeycode.restype = ctypes.c_ubyte
    x.XKeysymToKeycode.argtypes = [ctypes.c_void_p, ctypes.c_ulong]
    x.XQueryTree.argtypes = [ctypes.c_void_p, ctypes.c_ulong, *[ctypes.c_void_p] * 4]
    x.XSendEvent.argtypes = [ctypes.c_void_p, ctypes.c_ulong, ctypes.c_int, ctypes.c_long, ctypes.c_void_p]
    x.XFetchName.argtypes = [ctypes.c_void_p, ctypes.c_ulong, ctypes.c_void_p]
    x.XFree.argtypes = x.XCloseDisplay.argtypes = [ctypes.c_void_p]
    x.XSync.argtypes = [ctypes.c_void_p, ctypes.c_int]
    x.XGetImage.restype = ctypes.POINTER(_Image)
    x.XGetImage.argtypes = [ctypes.c_void_p, ctypes.c_ulong, *[ctypes.c_int] * 2, *[ctypes.c_uint] * 2]
    x.XGetImage.argtypes += [ctypes.c_ulong, ctypes.c_int]
    x.XDestroyImage.argtypes = [ctypes.c_void_p]
    return x


@contextmanager
def _display() -> Iterator[tuple[ctypes.CDLL, int]]:
    x = _library()
    display = x.XOpenDisplay(os.environ.get("DISPLAY", "").encode())
    if not display:
        raise RuntimeError("keys and screenshots go through an X server, and DISPLAY names none")
    try:
        yield x, display
    finally:
        x.XCloseDisplay(display)


def _windows(x: ctypes.CDLL, display: int) -> list[int]:
    """Windows with a name; on a screen of its own, with no window manager, those are Blender's."""
    root, parent = ctypes.c_ulong(), ctypes.c_ulong()
    children, count = ctypes.POINTER(ctypes.c_ulong)(), ctypes.c_uint()
    top = x.XDefaultRootWindow(display)
    x.XQueryTree(display, top, *(ctypes.byref(part) for part in (root, parent, children, count)))
    named = []
    for window in children[: count.value]:
        name = ctypes.c_char_p()
        if x.XFetchName(display, window, ctypes.byref(name)) and name.value:
            named.append(window)
    if count.value:
        x.XFree(children)
    return named


def press_key(name: str) -> float:
    """Press a key ("ESC" or "F12") and let it go, in all windows of a screen that Blender has for itself.

    Returns
    -------
    float
        When the X server got it, by ``time.perf_counter``: the way there takes a while where many threads run.

    Raises
    ------
    RuntimeError
        If there is no X server or no window.
    """
    with _display() as (x, display):
        windows = _windows(x, display)
        if not windows:
            raise RuntimeError("the X server shows no window with a name")
        for window in windows:
            for kind in (_PRESS, _RELEASE):
                event = _Event()
                event.key = _KeyEvent(
                    type=kind,
                    display=display,
                    window=window,
                    time=int(1000 * time.monotonic()) & 0x7FFFFFFF,  # a press at the time of a release is a repetition
                    root=x.XDefaultRootWindow(display),
                    x=40,
                    y=40,
                    x_root=40,
                    y_root=40,
                    keycode=x.XKeysymToKeycode(display, _KEYSYMS[name]),
                    same_screen=1,
                )
                x.XSendEvent(display, window, 1, _MASKS[kind], ctypes.byref(event))
        sent = time.perf_counter()
        x.XSync(display, 0)  # events wait in this program until then
    return sent


def screen_pixels(left: int, top: int, width: int, height: int) -> NDArray[np.uint8]:
    """What the screen shows in a rectangle, as (height, width, 3) bytes of R, G, B; row 0 is the top."""
    with _display() as (x, display):
        every_plane, as_pixels = 0xFFFFFFFF, 2
        image = x.XGetImage(display, x.XDefaultRootWindow(display), left, top, width, height, every_plane, as_pixels)
        if not image:
            raise RuntimeError(f"the screen has no rectangle of {width} x {height} pixels at ({left}, {top})")
        found = image.contents
        assert found.bits_per_pixel == 32, f"a screen of {found.bits_per_pixel} bits a pixel"
        data = ctypes.string_at(found.data, found.bytes_per_line * found.height)
        rows = np.frombuffer(data, np.uint8).reshape(found.height, found.bytes_per_line // 4, 4)
        pixels = np.ascontiguousarray(rows[:, : found.width, 2::-1])  # the screen has B, G, R
        x.XDestroyImage(image)
    return pixels


def write_png(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write 8-bit R, G, B."""
    height, width, _ = pixels.shape
    rows = np.zeros((height, 1 + 3 * width), np.uint8)  # each row begins with its filter: none
    rows[:, 1:] = pixels.reshape(height, -1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + body)
