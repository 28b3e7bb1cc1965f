# The service in a container: docs/operations.md says how to run it, docs/decisions/container-image.md
# why it is built like this. The RUN lines call docker/image, whose steps CI runs as they stand here.

FROM python:3.11.15-slim-bookworm AS build

# The CPU's name and features are part of the key that compiled kernels are kept under. Fixed ones
# make kernels of the build machine serve on every CPU of the architecture.
ENV INSTALL_ROOT=/opt/gamut \
    NUMBA_CPU_NAME=generic \
    NUMBA_CPU_FEATURES="" \
    PIP_DISABLE_PIP_VERSION_CHECK=1 \
    PIP_NO_CACHE_DIR=1 \
    PIP_ROOT_USER_ACTION=ignore

WORKDIR /build
COPY docker/image docker/image
COPY constraints.txt pyproject.toml ./
RUN docker/image dependencies
COPY LICENSE README.md ./
COPY gamutcore gamutcore
COPY service service
RUN docker/image package


FROM python:3.11.15-slim-bookworm

LABEL org.opencontainers.image.title="gamut-boundary-service" \
      org.opencontainers.image.description="Gamut boundaries at any triangle count, over HTTP" \
      org.opencontainers.image.licenses="Apache-2.0" \
      org.opencontainers.image.base.name="python:3.11.15-slim-bookworm"

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

USER 10001:10001
WORKDIR /data
VOLUME ["/data"]
EXPOSE 8000

HEALTHCHECK --interval=30s --timeout=3s --start-period=10s --retries=3 \
    CMD ["python", "-c", "import http.client, os; c = http.client.HTTPConnection('127.0.0.1', int(os.environ['GAMUT_PORT']), timeout=2); c.request('GET', '/livez'); raise SystemExit(c.getresponse().status != 200)"]

CMD ["gamut", "serve"]
