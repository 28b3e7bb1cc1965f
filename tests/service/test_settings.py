from pathlib import Path

import pytest
from pydantic import ValidationError

from service.settings import Settings, settings_table

DOCUMENT = Path(__file__).parents[2] / "docs" / "settings.md"


def test_every_setting_is_documented_as_it_is():
    assert settings_table() in DOCUMENT.read_text()


def test_every_setting_has_a_description():
    assert all(field.description for field in Settings.model_fields.values())


@pytest.mark.parametrize("name", Settings.model_fields)
def test_every_setting_comes_from_its_variable(monkeypatch, name):
    other = {
        "store": "elsewhere",
        "keep_inputs": False,
        "broker": "amqps://user:password@broker//",
        "host": "0.0.0.0",  # noqa: S104 - nothing listens here
        "log_level": "debug",
        "api_keys": f"name:read:{'0' * 64}",
        "allow_anonymous": "read",
        "trusted_proxies": "10.0.0.0/8",
        "cors_origins": "https://example.org",
        "log_format": "json",
        "access_log": True,
        "traces": "on",
        "worker_metrics_port": 9464,
        "max_surface_samples": 500_000,
        "build_workers": 7,
        "build_attempts": 7,
        "build_memory_bytes": 256 << 20,
        "max_page_size": 7,
    }.get(name, 2048)
    assert Settings.model_fields[name].default != other
    if name == "broker":
        monkeypatch.setenv("GAMUT_STORE", "s3://bucket")
    monkeypatch.setenv(f"GAMUT_{name.upper()}", str(other))
    assert getattr(Settings(), name) == other


@pytest.mark.parametrize("value", ["inf", "nan", "1e999"])
@pytest.mark.parametrize(
    "name", [name for name, field in Settings.model_fields.items() if field.annotation is float]
)
def test_seconds_and_rates_have_an_end(monkeypatch, name, value):
    monkeypatch.setenv(f"GAMUT_{name.upper()}", value)
    with pytest.raises(ValidationError):
        Settings()


def test_a_build_may_have_no_limit_of_memory():
    assert Settings(build_memory_bytes=0).build_memory_bytes == 0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("port", 65536),
        ("build_workers", 0),
        ("build_timeout", 0),
        ("build_memory_bytes", 5),
        ("build_memory_bytes", (256 << 20) - 1),
        ("log_level", "loud"),
        ("api_keys", "name:read:secret"),
        ("cors_origins", "example.org"),
        ("trusted_proxies", "proxy.example.org"),
        ("trusted_proxies", "10.0.0.1,10.0.0.0/33"),
    ],
)
def test_values_out_of_range_are_refused(name, value):
    with pytest.raises(ValidationError, match=name):
        Settings(**{name: value})


@pytest.mark.parametrize("proxies", ["", "*", "10.0.0.1, 10.1.0.0/16,::1", "2001:db8::/32"])
def test_proxies_are_addresses_networks_or_all(proxies):
    assert Settings(trusted_proxies=proxies).trusted_proxies == proxies


@pytest.mark.parametrize("broker", ["localhost", "http://broker", "sqs://", "memory://"])
def test_a_broker_of_another_kind_is_refused(broker):
    with pytest.raises(ValidationError, match="redis://"):
        Settings(store="s3://bucket", broker=broker)


def test_a_broker_needs_a_store_that_is_shared():
    with pytest.raises(ValidationError, match="GAMUT_STORE must be a bucket"):
        Settings(store="var/gamuts", broker="redis://broker/0")


def test_the_password_of_a_broker_is_not_told():
    assert "secret" not in repr(Settings(store="s3://bucket", broker="redis://:secret@broker/0"))


def test_listens_on_loopback_by_default():
    assert Settings().host == "127.0.0.1"
