"""Dichromatic: spectral rendering with the dichromatic reflection models. Blender's door to the extension."""


def register() -> None:
    """Register the extension with Blender."""
    from . import dichromatic_addon

    dichromatic_addon.register()


def unregister() -> None:
    """Take the extension out of Blender."""
    from . import dichromatic_addon

    dichromatic_addon.unregister()
