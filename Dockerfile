# avsec-gym on a CPU: `docker build -t avsec-gym .`, then `docker run --rm avsec-gym evaluate`.
# Results and the cache of rendered scenes stay in /data where a volume is mounted there:
# `mkdir -p data; docker run --rm --user "$(id -u):$(id -g)" -v "$PWD/data:/data" avsec-gym demo`.
# Its lines were tried by hand; the building of the image is untested.
FROM python:3.11-slim
# numba compiles by itself; opencv-python-headless, embreex and torch bring their libraries.
ENV PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1
WORKDIR /opt/avsec-gym
COPY constraints.txt .
# torch first and from its index of CPU builds: the one on PyPI brings CUDA, which is 5 GB.
RUN python -m pip install "$(grep '^torch==' constraints.txt)" --extra-index-url https://download.pytorch.org/whl/cpu -c constraints.txt
COPY pyproject.toml setup.py MANIFEST.in README.md LICENSE ./
COPY avsec_gym avsec_gym
RUN python -m pip install . -c constraints.txt
WORKDIR /data
ENV XDG_CACHE_HOME=/data/cache
ENTRYPOINT ["avsec"]
CMD ["--help"]
