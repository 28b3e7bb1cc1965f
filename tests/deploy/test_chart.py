"""The Helm chart, rendered by Helm's library and checked against the schemas of Kubernetes."""

import importlib
import re
from pathlib import Path

import pytest
import yaml

from gamutcore.version import __version__
from service.settings import ENVIRONMENT_PREFIX, Settings
from tests.conftest import missing

ROOT = Path(__file__).parents[2]
CHART = ROOT / "deploy" / "helm" / "gamut"
KUBERNETES = ("1.29", "1.33", "1.37")

NEEDED = {"store": {"url": "s3://bucket/prefix"}, "secret": {"name": "gamut"}}
REDIS = {"worker": {"autoscaling": {"keda": {"redisAddress": "redis:6379"}}}}


def merged(*values):
    """Merge mappings recursively; later values win."""
    result = {}
    for each in values:
        for name, value in each.items():
            if isinstance(value, dict) and isinstance(result.get(name), dict):
                result[name] = merged(result[name], value)
            else:
                result[name] = value
    return result


CASES = {
    "redis": merged(NEEDED, REDIS),
    "redis with a password": merged(
        NEEDED, REDIS, {"worker": {"autoscaling": {"keda": {"redisPasswordKey": "password"}}}}
    ),
    "rabbitmq": merged(NEEDED, {"broker": {"kind": "rabbitmq"}}),
    "hpa for workers": merged(
        NEEDED,
        {"worker": {"autoscaling": {"kind": "hpa", "hpa": {"selector": {"matchLabels": {}}}}}},
    ),
    "fixed numbers": merged(
        NEEDED,
        {
            "worker": {"autoscaling": {"kind": "none"}, "replicas": 3},
            "api": {"autoscaling": {"enabled": False}, "replicas": 4},
        },
    ),
    "everything": merged(
        NEEDED,
        REDIS,
        {
            "ingress": {
                "enabled": True,
                "className": "nginx",
                "host": "gamuts.example",
                "tlsSecretName": "tls",
                "annotations": {"a/b": "c"},
            },
            "networkPolicy": {"enabled": True, "from": [{"podSelector": {}}]},
            "settings": {"GAMUT_BUILD_QUEUE": 200, "GAMUT_ACCESS_LOG": True},
            "serviceAccount": {"annotations": {"role": "reader"}},
            "imagePullSecrets": [{"name": "registry"}],
            "service": {"type": "NodePort", "annotations": {"a": "b"}},
            "monitoring": {
                "annotations": True,
                "serviceMonitor": {"enabled": True},
                "podMonitor": {"enabled": True},
                "labels": {"release": "prometheus"},
                "apiKey": {"secret": "prometheus", "key": "gamut"},
            },
            "api": {
                "podLabels": {"a": "b"},
                "podAnnotations": {"a": "b"},
                "nodeSelector": {"disk": "ssd"},
                "tolerations": [{"key": "spot", "operator": "Exists"}],
                "affinity": {"podAntiAffinity": {}},
                "podDisruptionBudget": {"maxUnavailable": "50%"},
            },
        },
    ),
}  # fmt: skip


def package(name):
    """Import a package of the extra lint, or skip if the extra is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        missing(f"{name} is not installed: make lint installs it")


@pytest.fixture(scope="module")
def helm():
    return package("helm_python")


@pytest.fixture(scope="module")
def rendered(helm):
    """Return a function from values to the rendered objects, by kind and component."""

    def objects(values):
        with helm.Chart.load(CHART) as chart:
            files = chart.render(values, name="demo", namespace="somewhere")
        found = {}
        for name, text in files.items():
            if not name.endswith(".yaml"):
                continue
            for each in filter(None, yaml.safe_load_all(text)):
                labels = each["metadata"]["labels"]
                key = (each["kind"], labels.get("app.kubernetes.io/component"))
                assert key not in found
                found[key] = each
        return found

    return objects


@pytest.mark.parametrize("case", CASES)
def test_helm_finds_nothing_to_complain_about(helm, case):
    report = helm.lint(CHART, CASES[case], strict=True)
    assert report["errors"] == []
    assert [each for each in report["messages"] if each["severity"] > 1] == []


@pytest.mark.parametrize("case", CASES)
@pytest.mark.slow
def test_every_object_is_one_that_kubernetes_takes(rendered, case):
    """The schemas do not include the kinds of KEDA and of the Prometheus operator."""
    schemas = package("kubernetes_validate")
    kinds = set()
    for (kind, _), each in rendered(CASES[case]).items():
        kinds.add(kind)
        if not each["apiVersion"].startswith(("keda.sh/", "monitoring.coreos.com/")):
            for version in KUBERNETES:
                schemas.validate(each, version, strict=True)
    assert {"Deployment", "Service", "ConfigMap", "ServiceAccount", "PodDisruptionBudget"} <= kinds


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({}, "secret.name|store.url"),
        (NEEDED, "redisAddress"),
        ({"store": {"url": "/srv/gamuts"}}, "store"),
        ({"worker": {"autoscaling": {"kind": "magic"}}}, "kind"),
        ({"workers": {}}, "workers"),
        ({"settings": {"GAMUT_STORE": "s3://other"}}, "GAMUT_STORE"),
        ({"settings": {"GAMUT_WORKER_METRICS_PORT": "1"}}, "GAMUT_WORKER_METRICS_PORT"),
        (
            merged(
                CASES["redis"],
                {"worker": {"metricsPort": 0}, "monitoring": {"podMonitor": {"enabled": True}}},
            ),
            "metricsPort",
        ),
        (merged(CASES["everything"], {"monitoring": {"apiKey": {"key": ""}}}), "apiKey.key"),
        ({"monitoring": {"interval": "often"}}, "interval"),
        (merged(NEEDED, REDIS, {"ingress": {"enabled": True}}), "ingress.host"),
    ],
)
def test_values_that_make_no_cluster_are_refused_by_name(helm, rendered, values, named):
    def checked_and_rendered():
        with helm.Chart.load(CHART) as chart:
            chart.validate_schema(values)
        rendered(values)

    with pytest.raises(helm.HelmError, match=named):
        checked_and_rendered()


@pytest.mark.parametrize("component", ["api", "worker"])
def test_pods_have_no_rights_and_a_read_only_root(rendered, component):
    pod = rendered(CASES["redis"])["Deployment", component]["spec"]["template"]["spec"]
    assert pod["automountServiceAccountToken"] is False
    assert pod["securityContext"]["runAsNonRoot"] is True
    user = re.findall(r"^USER (\d+):(\d+)", (ROOT / "Dockerfile").read_text(), re.MULTILINE)[-1]
    context = pod["securityContext"]
    assert (context["runAsUser"], context["runAsGroup"]) == tuple(map(int, user))
    (container,) = pod["containers"]
    assert container["securityContext"] == {
        "allowPrivilegeEscalation": False,
        "readOnlyRootFilesystem": True,
        "capabilities": {"drop": ["ALL"]},
    }
    assert set(container["resources"]) == {"requests", "limits"}
    assert {"startupProbe", "livenessProbe", "readinessProbe"} <= set(container)


@pytest.mark.parametrize("component", ["api", "worker"])
def test_a_pod_is_given_longer_than_its_drain(rendered, component):
    values = merged(CASES["redis"], {component: {"drainSeconds": 300}})
    pod = rendered(values)["Deployment", component]["spec"]["template"]["spec"]
    (container,) = pod["containers"]
    variables = {each["name"]: each.get("value") for each in container["env"]}
    assert variables["GAMUT_DRAIN_SECONDS"] == "300"
    assert pod["terminationGracePeriodSeconds"] >= 300 + 15


def test_the_figures_of_workers_have_a_port_or_none(rendered):
    for port in (9464, 0):
        values = merged(
            CASES["redis"], {"networkPolicy": {"enabled": True}, "worker": {"metricsPort": port}}
        )
        objects = rendered(values)
        pod = objects["Deployment", "worker"]["spec"]["template"]["spec"]
        ports = [each["containerPort"] for each in pod["containers"][0].get("ports", [])]
        assert ports == ([port] if port else [])
        let_in = objects["NetworkPolicy", "worker"]["spec"]["ingress"]
        assert bool(let_in) == bool(port)


class TestMonitoring:
    def test_nothing_of_it_is_there_by_default(self, rendered):
        objects = rendered(CASES["redis"])
        assert not {kind for kind, _ in objects} & {"ServiceMonitor", "PodMonitor"}
        for component in ("api", "worker"):
            template = objects["Deployment", component]["spec"]["template"]
            annotations = template["metadata"]["annotations"]
            assert not [name for name in annotations if name.startswith("prometheus.io/")]

    def test_annotations_name_the_port_that_the_figures_are_at(self, rendered):
        objects = rendered(CASES["everything"])
        for component in ("api", "worker"):
            template = objects["Deployment", component]["spec"]["template"]
            annotations = template["metadata"]["annotations"]
            (container,) = template["spec"]["containers"]
            (port,) = container["ports"]
            assert annotations["prometheus.io/scrape"] == "true"
            assert annotations["prometheus.io/port"] == str(port["containerPort"])
            assert annotations["prometheus.io/path"] == "/metrics"

    def test_monitors_select_what_they_are_for_by_ports_that_exist(self, rendered):
        objects = rendered(CASES["everything"])
        service, pod = (
            objects["Service", "api"],
            objects["Deployment", "worker"]["spec"]["template"],
        )
        (endpoint,) = objects["ServiceMonitor", "api"]["spec"]["endpoints"]
        assert endpoint["port"] in {port["name"] for port in service["spec"]["ports"]}
        credentials = {"name": "prometheus", "key": "gamut"}
        assert endpoint["authorization"] == {"type": "Bearer", "credentials": credentials}
        (pod_endpoint,) = objects["PodMonitor", "worker"]["spec"]["podMetricsEndpoints"]
        assert pod_endpoint["port"] == pod["spec"]["containers"][0]["ports"][0]["name"]
        for kind, labels in (
            ("ServiceMonitor", service["metadata"]["labels"]),
            ("PodMonitor", pod["metadata"]["labels"]),
        ):
            (monitor,) = [each for (name, _), each in objects.items() if name == kind]
            assert monitor["spec"]["selector"]["matchLabels"].items() <= labels.items()
            assert monitor["spec"]["namespaceSelector"] == {"matchNames": ["somewhere"]}
            assert monitor["metadata"]["labels"]["release"] == "prometheus"


def test_the_variables_are_settings_of_the_service(rendered):
    objects = rendered(CASES["everything"])
    names = set(objects["ConfigMap", None]["data"])
    for component in ("api", "worker"):
        pod = objects["Deployment", component]["spec"]["template"]["spec"]
        names |= {each["name"] for each in pod["containers"][0]["env"]}
    known = {f"{ENVIRONMENT_PREFIX}{name.upper()}" for name in Settings.model_fields}
    assert names <= known


def test_workers_are_scaled_by_the_queue_that_they_take_from(rendered):
    from service.broker.celery_app import QUEUE

    scaled = rendered(CASES["redis"])["ScaledObject", "worker"]["spec"]
    assert scaled["triggers"][0]["metadata"]["listName"] == QUEUE
    assert scaled["scaleTargetRef"]["name"] == "demo-gamut-worker"
    objects = rendered(CASES["rabbitmq"])
    (trigger,) = objects["ScaledObject", "worker"]["spec"]["triggers"]
    assert trigger["metadata"]["queueName"] == QUEUE
    (secret,) = objects["TriggerAuthentication", "worker"]["spec"]["secretTargetRef"]
    assert (secret["parameter"], secret["key"]) == ("host", "GAMUT_BROKER")


def test_autoscaling_and_a_fixed_number_exclude_each_other(rendered):
    for component in ("api", "worker"):
        assert "replicas" not in rendered(CASES["redis"])["Deployment", component]["spec"]
    fixed = rendered(CASES["fixed numbers"])
    assert fixed["Deployment", "api"]["spec"]["replicas"] == 4
    assert fixed["Deployment", "worker"]["spec"]["replicas"] == 3
    assert not {kind for kind, _ in fixed} & {"HorizontalPodAutoscaler", "ScaledObject"}
    assert ("HorizontalPodAutoscaler", "worker") in rendered(CASES["hpa for workers"])


def test_the_chart_is_of_this_version():
    chart = yaml.safe_load((CHART / "Chart.yaml").read_text())
    assert chart["appVersion"] == __version__
