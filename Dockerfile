# The service in a container. docs/operations.md explains how to run it, and
# docs/decisions/container-image.md why it is built this way.

# Both stages use one base. It must have python3 with its venv module. CI passes another name here,
# because its machine has no registry to take this image from. A tag moves with security updates. To
# build from one image for ever, give its digest: --build-arg BASE=python@sha256:..., which
# `docker buildx imagetools inspect python:3.11.15-slim-bookworm` prints.
ARG BASE=python:3.11.15-slim-bookworm


FROM ${BASE} AS build

# Numba keeps compiled kernels under a key that includes the name and the features of the CPU. Fixed
# values make kernels of the build machine load on every CPU of the architecture.
ENV NUMBA_CPU_NAME=generic \
    NUMBA_CPU_FEATURES="" \
    PIP_DISABLE_PIP_VERSION_CHECK=1 \
    PIP_NO_CACHE_DIR=1 \
    PIP_ROOT_USER_ACTION=ignore

WORKDIR /build
COPY . .

# pip verifies the hashes in the lock files (docker/lock.py). The project is built with the locked
# backend and nothing else. One image serves every role, therefore it has the packages of a cluster.
RUN python3 -m venv /build/venv && \
    /build/venv/bin/python -m pip install -q --require-hashes -r docker/requirements-build.txt && \
    /build/venv/bin/python -m pip wheel -q --no-deps --no-build-isolation -w /build/dist . && \
    python3 -m venv /opt/gamut && \
    /opt/gamut/bin/python -m pip install -q --require-hashes -r docker/requirements.txt && \
    /opt/gamut/bin/python -m pip install -q --no-deps --no-index /build/dist/*.whl && \
    /opt/gamut/bin/python -m pip check && \
    /opt/gamut/bin/python -m pip uninstall -q --yes pip setuptools && \
    /opt/gamut/bin/python docker/sbom.py > /opt/gamut/sbom.cdx.json

# Wheels bring 150 MB that no program uses: tests, and a report of their coverage in colour-science.
RUN packages=$(/opt/gamut/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))') && \
    rm -rf "$packages/colour/htmlcov" && \
    find "$packages/colour" "$packages/numba" "$packages/numpy" "$packages/scipy" \
        -depth -type d -name tests -exec rm -rf {} +

# Kernels that lie beside the sources are kept where they fit: compiled for this CPU from these sources.
RUN packages=$(/opt/gamut/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))') && \
    find gamutcore -name '*.nbc' -exec cp --parents -t "$packages" {} +

# From another directory, so that the installed package is compiled and not its source.
WORKDIR /
RUN /opt/gamut/bin/python -m gamutcore.warm && \
    install -d -o 10001 -g 10001 -m 0750 /data


FROM ${BASE}

ARG VERSION=0.1.0
ARG REVISION=unknown

LABEL org.opencontainers.image.title="gamut-boundary-service" \
      org.opencontainers.image.version="${VERSION}" \
      org.opencontainers.image.revision="${REVISION}" \
      org.opencontainers.image.description="Gamut boundaries at any triangle count, over HTTP" \
      org.opencontainers.image.licenses="Apache-2.0"

ENV PATH=/opt/gamut/bin:/usr/local/bin:/usr/local/sbin:/usr/sbin:/usr/bin:/sbin:/bin \
    NUMBA_CPU_NAME=generic \
    NUMBA_CPU_FEATURES="" \
    MALLOC_ARENA_MAX=2 \
    PYTHONDONTWRITEBYTECODE=1 \
    PYTHONUNBUFFERED=1 \
    HOME=/tmp \
    GAMUT_STORE=/data \
    GAMUT_HOST=0.0.0.0 \
    GAMUT_PORT=8000

COPY --from=build /opt/gamut /opt/gamut
COPY --from=build --chown=10001:10001 /data /data

# The official base has no bytecode of the standard library, and the user cannot write any: each start
# would compile 211 modules, which takes half a second in the server and in the build worker.
RUN env -u PYTHONDONTWRITEBYTECODE gamut openapi > /dev/null

USER 10001:10001
WORKDIR /data
VOLUME ["/data"]
EXPOSE 8000

HEALTHCHECK --interval=30s --timeout=3s --start-period=10s --retries=3 \
    CMD ["python", "-c", "import http.client, os; c = http.client.HTTPConnection('127.0.0.1', int(os.environ['GAMUT_PORT']), timeout=2); c.request('GET', '/livez'); raise SystemExit(c.getresponse().status != 200)"]

CMD ["gamut", "serve"]
