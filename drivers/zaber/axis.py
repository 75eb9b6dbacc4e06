"""One axis of a Zaber controller: millimetres on this side, packets with id and checksum on the other."""

from dataclasses import replace
from typing import Final

from drivers.polled_stage import Status
from drivers.serial_line import Answer, LineWire
from drivers.zaber.codec import IDS, Reply, command, parse
from drivers.zaber.flags import NOT_HOMED, REMEDY, in_words
from drivers.zaber.settings import ZaberSettings
from protocols import DeviceRefused, DeviceTimeout, MotionProfile, PlanError, ProtocolViolation


class ZaberAxis:
    """Satisfies ``drivers.polled_stage.Axis``.

    Each command has a message id of its own, and only the reply with that id is its answer: what is late, doubled, damaged
    or not meant for us is passed over. Once a reply has carried a checksum, those without are damaged too. A question that
    gets no answer is asked once more; a command that moves is not.
    """

    def __init__(self, wire: LineWire, settings: ZaberSettings) -> None:
        self._wire: Final = wire
        self._settings: Final = settings
        self._id = 0
        self._checked = False
        self._told: tuple[int, int] | None = None
        """Speed and acceleration that the controller has been told."""

    @property
    def tolerance_mm(self) -> float:
        """See ``Axis``: one and a half microsteps."""
        return 1.5 / self._settings.microsteps_per_mm

    @property
    def stops(self) -> int:
        """See ``Axis``."""
        return self._wire.stops

    def status(self) -> Status:
        """See ``Axis``.

        Raises:
            ProtocolViolation: a position that is no number.
        """
        answer = self.query("get pos")
        reply = answer.value
        try:
            microsteps = int(reply.data)
        except ValueError:
            raise ProtocolViolation(
                device=self._wire.device,
                saw=f"a position of {reply.data!r}",
                expected="a whole number of microsteps",
                remedy="see whether axis in bench.toml names one axis of one device",
            ) from None
        fault = reply.warning.startswith("F")
        return Status(
            time_s=answer.time_s,
            mm=microsteps / self._settings.microsteps_per_mm,
            moving=reply.busy,
            homed=not fault and reply.warning not in NOT_HOMED,
            trouble=in_words(reply.warning),
        )

    def query(self, words: str) -> Answer[Reply]:
        """Ask, and once more where no answer comes.

        Raises:
            DeviceTimeout: no answer, twice.
            DeviceRefused: rejected.
        """
        try:
            return self._exchange(words)
        except DeviceTimeout:
            return self._exchange(words)

    def check(self, profile: MotionProfile) -> None:
        """See ``Axis``: it starts from rest, and in whole units of the controller."""
        settings = self._settings
        if profile.initial_velocity_mm_s:
            raise PlanError(
                device=self._wire.device,
                saw=f"a start velocity of {profile.initial_velocity_mm_s:g} mm/s",
                expected="0: the controller ramps up from rest",
                remedy="leave initial_velocity_mm_s out of plan.toml",
            )
        speed, acceleration = self._figures(profile)
        if min(speed, acceleration) < 1:
            least = 1 / (settings.microsteps_per_mm * settings.acceleration_factor)
            raise PlanError(
                device=self._wire.device,
                saw=f"{profile.velocity_mm_s:g} mm/s and {profile.acceleration_mm_s2:g} mm/s^2",
                expected=f"at least {1 / (settings.microsteps_per_mm * settings.speed_factor):.3g} mm/s and {least:.3g} mm/s^2",
                remedy="raise velocity or acceleration in plan.toml",
            )

    def runs(self, profile: MotionProfile) -> MotionProfile:
        """See ``Axis``."""
        settings = self._settings
        speed, acceleration = self._figures(profile)
        return MotionProfile(
            velocity_mm_s=speed / settings.speed_factor / settings.microsteps_per_mm,
            acceleration_mm_s2=acceleration / settings.acceleration_factor / settings.microsteps_per_mm,
        )

    def begin_move(self, target_mm: float, profile: MotionProfile, *, stops: int) -> None:
        """See ``Axis``."""
        self._set_speeds(profile)
        self._exchange(f"move abs {round(target_mm * self._settings.microsteps_per_mm)}", stops)

    def begin_home(self, profile: MotionProfile, *, stops: int) -> None:
        """See ``Axis``."""
        self._set_speeds(profile)
        self._exchange("home", stops)

    def send_stop(self) -> None:
        """See ``Axis``. Its reply has an id that nobody waits for."""
        self._wire.stop(command(self._settings.device, self._settings.axis, self._next_id(), "stop"))

    def close(self) -> None:
        """See ``Axis``."""
        self._wire.close()

    def _figures(self, profile: MotionProfile) -> tuple[int, int]:
        settings = self._settings
        speed = round(profile.velocity_mm_s * settings.microsteps_per_mm * settings.speed_factor)
        return speed, round(profile.acceleration_mm_s2 * settings.microsteps_per_mm * settings.acceleration_factor)

    def _set_speeds(self, profile: MotionProfile) -> None:
        figures = self._figures(profile)
        if figures == self._told:
            return
        self._told = None
        self.query(f"set maxspeed {figures[0]}")  # to set the same twice does no harm
        self.query(f"set accel {figures[1]}")
        self._told = figures

    def _next_id(self) -> int:
        self._id = (self._id + 1) % IDS
        return self._id

    def _exchange(self, words: str, stops: int | None = None) -> Answer[Reply]:
        settings = self._settings
        with self._wire.turn:
            message_id = self._next_id()
            begun: list[Reply] = []

            def mine(line: bytes) -> Reply | None:
                packet = parse(line, unchecked=not self._checked)
                if packet is None or (packet.device, packet.axis, packet.message_id) != (
                    settings.device,
                    settings.axis,
                    message_id,
                ):
                    return None
                if not isinstance(packet, Reply):
                    if not begun:
                        return None
                    before = begun.pop()
                    packet = replace(before, data=f"{before.data} {packet.data}", more=packet.more)
                if packet.more:
                    begun[:] = [packet]
                    return None
                return packet

            answer = self._wire.exchange(
                command(settings.device, settings.axis, message_id, words),
                mine,
                f"the reply with id {message_id:02d}",
                unless_stopped_since=stops,
            )
        reply = answer.value
        self._checked |= reply.checked
        if not reply.accepted:
            raise DeviceRefused(
                self._wire.device,
                code=reply.data,
                saw=f"`{words}` rejected{f', flag {in_words(reply.warning)}' if reply.warning else ''}",
                expected="OK",
                remedy=REMEDY.get(reply.data, "look the reason up in the maker's ASCII protocol manual"),
            )
        return answer
