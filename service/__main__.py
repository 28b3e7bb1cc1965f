"""Entry point of the console script ``gamut`` and of ``python -m service``.

The web packages are the extra ``service`` of the distribution. Without them, the command says what
to install instead of ending with a traceback.
"""

import importlib.util
import sys

__all__ = ["main"]

_WEB_PACKAGES = ("fastapi", "prometheus_client", "pydantic_settings", "python_multipart", "uvicorn")
"""One module of each package that the extra installs and that the service imports at start."""


def main() -> int:
    """Run the command line and return its exit status."""
    missing = [name for name in _WEB_PACKAGES if importlib.util.find_spec(name) is None]
    if missing:
        print(  # noqa: T201  # the command line's answer
            f"gamut needs packages that are not installed: {', '.join(missing)}. "
            "Install them with: pip install 'gamut-boundary-service[service]'",
            file=sys.stderr,
        )
        return 1
    from service.command import main as run  # noqa: PLC0415  # needs the web packages

    return run()


if __name__ == "__main__":
    sys.exit(main())
