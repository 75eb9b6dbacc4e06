"""What every device has: a name, and the device that it is part of."""


class Named:
    """A device with a name."""

    def __init__(self, name: str, parent: "Named | None" = None) -> None:
        """Take the name.

        Args:
            name: of the device in documents.
            parent: the device that it is part of.
        """
        self._name = name
        self._parent = parent

    @property
    def name(self) -> str:
        """Name of the device in documents."""
        return self._name

    @property
    def parent(self) -> "Named | None":
        """The device that it is part of; None for one that stands by itself."""
        return self._parent
