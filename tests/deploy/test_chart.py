"""The Helm chart, rendered by Helm's library and checked against the schemas of Kubernetes."""

import importlib
import re
from pathlib import Path

import pytest
import yaml

from gamutcore.version import __version__
from service.settings import ENVIRONMENT_PREFIX, Settings
from tests.conftest import missing

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]
CHART = ROOT / "deploy" / "helm" / "gamut"
KUBERNETES = ("1.29", "1.33", "1.37")

NEEDED = {"store": {"url": "s3://bucket/prefix"}, "secret": {"name": "gamut"}}


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


def scaled(**worker):
    return {"worker": {"autoscaling": worker}}


REDIS = scaled(keda={"redisAddress": "redis:6379"})
EVERYTHING = """
ingress: {enabled: true, className: nginx, host: gamuts.example, tlsSecretName: tls,
  annotations: {a/b: c}}
networkPolicy: {enabled: true, from: [{podSelector: {}}]}
settings: {GAMUT_BUILD_QUEUE: 200, GAMUT_ACCESS_LOG: true}
serviceAccount: {annotations: {role: reader}}
imagePullSecrets: [{name: registry}]
service: {type: NodePort, annotations: {a: b}}
monitoring:
  annotations: true
  serviceMonitor: {enabled: true}
  podMonitor: {enabled: true}
  labels: {release: prometheus}
  apiKey: {secret: prometheus, key: gamut}
api:
  podLabels: {a: b}
  podAnnotations: {a: b}
  nodeSelector: {disk: ssd}
  tolerations: [{key: spot, operator: Exists}]
  affinity: {podAntiAffinity: {}}
  podDisruptionBudget: {maxUnavailable: 50%}
"""

CASES = {
    "redis": merged(NEEDED, REDIS),
    "redis with a password": merged(NEEDED, REDIS, scaled(keda={"redisPasswordKey": "password"})),
    "hpa for workers": merged(NEEDED, scaled(kind="hpa", hpa={"selector": {"matchLabels": {}}})),
    "fixed numbers": merged(
        NEEDED,
        scaled(kind="none"),
        {"worker": {"replicas": 3}, "api": {"autoscaling": {"enabled": False}, "replicas": 4}},
    ),
    "everything": merged(NEEDED, REDIS, yaml.safe_load(EVERYTHING)),
}


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


def pod_of(objects, component):
    return objects["Deployment", component]["spec"]["template"]["spec"]


@pytest.mark.parametrize("case", CASES)
def test_helm_finds_nothing_to_complain_about(helm, case):
    report = helm.lint(CHART, CASES[case], strict=True)
    assert report["errors"] == []
    assert [each for each in report["messages"] if each["severity"] > 1] == []


@pytest.mark.parametrize("case", CASES)
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
    pod = pod_of(rendered(CASES["redis"]), component)
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
    # Nobody sends requests to a worker.
    probes = {"startupProbe", "livenessProbe"} | (
        {"readinessProbe"} if component == "api" else set()
    )
    assert probes <= set(container)


@pytest.mark.parametrize("component", ["api", "worker"])
def test_a_pod_is_given_longer_than_its_drain(rendered, component):
    values = merged(CASES["redis"], {component: {"drainSeconds": 300}})
    pod = pod_of(rendered(values), component)
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
        pod = pod_of(objects, "worker")
        ports = [each["containerPort"] for each in pod["containers"][0].get("ports", [])]
        assert ports == ([port] if port else [])
        let_in = objects["NetworkPolicy", "worker"]["spec"]["ingress"]
        assert bool(let_in) == bool(port)


class TestMonitoring:
    @pytest.mark.parametrize(("case", "there"), [("redis", False), ("everything", True)])
    def test_it_is_there_if_wanted_and_annotations_name_the_port_of_the_figures(
        self, rendered, case, there
    ):
        objects = rendered(CASES[case])
        monitors = {"ServiceMonitor", "PodMonitor"}
        assert monitors & {kind for kind, _ in objects} == (monitors if there else set())
        for component in ("api", "worker"):
            template = objects["Deployment", component]["spec"]["template"]
            (port,) = template["spec"]["containers"][0]["ports"]
            expected = {
                "prometheus.io/scrape": "true",
                "prometheus.io/port": str(port["containerPort"]),
                "prometheus.io/path": "/metrics",
            }
            annotations = template["metadata"]["annotations"].items()
            found = {name: value for name, value in annotations if name in expected}
            assert found == (expected if there else {})

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
        names |= {each["name"] for each in pod_of(objects, component)["containers"][0]["env"]}
    known = {f"{ENVIRONMENT_PREFIX}{name.upper()}" for name in Settings.model_fields}
    assert names <= known


def test_workers_are_scaled_by_the_queue_that_they_take_from(rendered):
    from service.broker.celery_app import QUEUE

    scaled = rendered(CASES["redis"])["ScaledObject", "worker"]["spec"]
    assert scaled["triggers"][0]["metadata"]["listName"] == QUEUE
    assert scaled["scaleTargetRef"]["name"] == "demo-gamut-worker"


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
