# The README's two commands in a clean Debian: docker build --tag helmbench . && docker run --rm helmbench
# Another command: docker run --rm -v "$PWD:/data" -w /data helmbench /helmbench/.venv/bin/helmbench check record.csv
FROM python:3.13-slim-trixie

RUN apt-get update -qq \
    && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium gcc git libc6-dev make \
    && rm -rf /var/lib/apt/lists/*
COPY . /helmbench
WORKDIR /helmbench
RUN make env
CMD ["sh", "-c", "make bench && make test"]
